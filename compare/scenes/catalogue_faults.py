"""Faults of what a catalogue gives: keys that say the same, circuits without gaps, preload that one nut cannot have."""

from __future__ import annotations

from collections.abc import Iterator

from rollbench.comparison.scenes.fault import Fault, mm
from rollbench.comparison.scenes.schema import SceneKeys

#: Part of a ball diameter by which a diameter may differ from twice the radius beside it.
SAME = 1e-9


def catalogue_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Faults that show before geometry is built."""
    yield from _twice(keys)
    yield from _circuits(keys)
    yield from _preload(keys)


def _twice(keys: SceneKeys) -> Iterator[Fault]:
    """A radius and a diameter that contradict one another, a count beside a filling."""
    pairs = (
        ("track.pitch_diameter", keys.track.pitch_diameter, keys.track.pitch_radius),
        ("balls.diameter", keys.balls.diameter, keys.balls.radius),
    )
    for where, diameter, radius in pairs:
        if diameter is not None and abs(diameter - 2.0 * radius) > SAME * radius:
            yield Fault((where,), f"{mm(2.0 * radius)}, twice the radius that is given too", "leave one of the two out")
    if keys.balls.count is not None and keys.balls.filling is not None:
        yield Fault(("balls.filling",), "either count or filling", "the filling sets the count: leave one out", "both")


def _circuits(keys: SceneKeys) -> Iterator[Fault]:
    balls, circuits = keys.balls, keys.balls.circuits
    listed = next((name for name in ("azimuths", "arcs") if getattr(balls, name) is not None), "")
    remedy = f"the {listed} say where the balls are: leave it out"
    for name in ("filling", "circuit_gap") if listed else ():
        if getattr(balls, name) is not None:
            advice = "write count instead" if (name, listed) == ("filling", "arcs") else remedy
            yield Fault((f"balls.{name}",), f"nothing together with {listed}", advice)
    if circuits == 1:
        if balls.circuit_gap is not None and not listed:
            yield Fault(("balls.circuits",), "2 or more with circuit_gap", "give circuits, or leave circuit_gap out", "one")
        return
    if listed:
        yield Fault(("balls.circuits",), f"1 together with {listed}", remedy)
    elif keys.track.lead == 0.0:
        yield Fault(("balls.circuits",), "1 for zero lead", "a bearing has one row")
    elif balls.circuit_gap is None:
        advice = "makers rarely print it: measure from ball to ball on a drawing, 0.3 to 1 turns are usual"
        value = f"{circuits} without circuit_gap"
        yield Fault(("balls.circuits",), "circuit_gap with it, the turns without balls between circuits", advice, value)
    stated = 1 if keys.circulation is None else keys.circulation.circuits
    if (keys.circulation is not None or keys.time is not None) and stated != circuits:
        advice = f"[balls] has {circuits} circuits of each start: write circuits = {circuits} under [circulation]"
        yield Fault(("circulation.circuits", "circulation", "time"), str(circuits), advice, str(stated))


def _preload(keys: SceneKeys) -> Iterator[Fault]:
    preload = keys.preload
    if preload is None:
        return
    given = [name for name in ("force", "oversize", "lead_offset") if getattr(preload, name) is not None]
    if len(given) != 1:
        where = (f"preload.{given[0] if given else 'force'}", "preload")
        yield Fault(where, "one of force, oversize and lead_offset", "leave the others out", " and ".join(given) or "none")
    if preload.lead_offset is not None and keys.track.lead == 0.0:
        yield Fault(("preload.lead_offset",), "a lead above zero", "rows of a bearing are [[sets]] with an offset")
    if preload.lead_offset is None and keys.errors.balls.oversize != 0.0:
        advice = "[preload] sets it: leave one of the two out"
        yield Fault(("errors.balls.oversize",), "0 um together with [preload]", advice)
