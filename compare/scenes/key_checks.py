"""Checks of contradictory keys of a scene file, before any geometry is built."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from rollbench.compare.scenes.fault import TOLERANCE, Fault, mm
from rollbench.compare.scenes.from_keys import ball_total, centres_apart
from rollbench.compare.scenes.keys import GrooveKeys
from rollbench.compare.scenes.schema import BallKeys, FrictionKeys, SceneKeys
from rollbench.meshes.parts import Motion, Time
from rollbench.meshes.ranges import MAX_BALLS
from rollbench.meshes.section import MERGE

#: Relative difference up to which a diameter agrees with twice a radius that is also given.
SAME = 1e-9


def choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of keys that exclude or need each other, and of invalid counts and supports."""
    for part in ("screw", "nut", "balls"):
        yield from _material_faults(keys, part)
    yield from _kind_faults(keys)
    yield from groove_choice_faults(keys.screw, "screw")
    yield from groove_choice_faults(keys.nut, "nut")
    yield from _angle_faults(keys)
    yield from _holding_faults(keys)
    yield from _ball_choice_faults(keys)
    yield from _support_faults(keys)
    yield from motion_faults(keys.motion)
    if keys.lubricant is not None and keys.track.lead != 0.0:
        advice = "friction of a nut goes by [friction]: leave the table out"
        yield Fault(("lubricant",), "a bearing (track.lead of 0 mm)", advice, "a ball screw with [lubricant]")
    yield from friction_choice_faults(keys.friction)
    yield from _circuit_choice_faults(keys)
    yield from _said_twice(keys)
    yield from _circuits(keys)
    yield from _preload(keys)
    yield from _operation(keys)


def motion_faults(motion: Motion | None) -> Iterator[Fault]:
    """Yield a fault for zero speed."""
    if motion is not None and motion.speed == 0.0:
        advice = "friction at rest may have any value up to its limit: give the speed at which the part turns"
        yield Fault(("motion.speed",), "any angular speed but zero", advice)


def _circuit_choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of the tables ``[circulation]`` and ``[time]``."""
    circulation = keys.circulation
    if circulation is not None:
        if keys.track.lead == 0.0:
            advice = "the balls of a bearing go round its one turn: leave the table out"
            yield Fault(("circulation",), "a lead above 0 mm", advice, "a bearing with [circulation]")
        if circulation.gap is not None and circulation.filling is not None:
            allowed, advice = "either gap or filling", "they say the same: leave one out"
            yield Fault(("circulation.gap",), allowed, advice, "both")
    if keys.time is not None:
        yield from time_faults(keys.time)


def time_faults(time: Time) -> Iterator[Fault]:
    """Yield a fault unless a run in time has either an angle or a duration."""
    if (time.angle is None) == (time.duration is None):
        value = "neither" if time.angle is None else "both"
        advice = 'write angle = "360 deg", or duration = "1 s"'
        yield Fault(("time.angle", "time"), "either angle or duration", advice, value)


def friction_choice_faults(friction: FrictionKeys | None) -> Iterator[Fault]:
    """Yield faults of a groove without coefficient, and of the former key ``coupling`` next to its new ones."""
    if friction is not None and friction.coefficient is None and None in (friction.screw, friction.nut):
        advice = "write e.g. coefficient = 0.1, or a coefficient for each groove, screw and nut"
        yield Fault(("friction.coefficient",), "0 to 2", advice, "nothing")
    if friction is not None and friction.coupling and friction.model_fields_set & {"feedback", "neighbours"}:
        advice = "coupling is the former key of feedback and neighbours: leave it out"
        yield Fault(("friction.coupling",), "either the former key or the two new ones", advice, "both")


def _kind_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield a fault if ``kind`` contradicts the lead."""
    kind = "bearing" if keys.track.lead == 0.0 else "ball screw"
    if keys.kind not in (None, kind):
        advice = f"a lead {'of zero' if keys.track.lead == 0.0 else 'above zero'} is a {kind}: mend kind or track.lead"
        yield Fault(("kind",), f'"{kind}" with this lead', advice)


def groove_choice_faults(groove: GrooveKeys, table: str) -> Iterator[Fault]:
    """Yield a fault unless a groove is given in exactly one form; ``table``: its table in the file."""
    if (groove.groove_radius is None) == (groove.conformity is None):
        given = "neither" if groove.conformity is None else "both"
        advice = "groove radius = conformity x ball diameter: give one and leave out the other"
        yield Fault((f"{table}.groove_radius",), "one of groove_radius and conformity", advice, given)


def _angle_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield a fault unless there is a contact angle, or the clearance of a bearing whose balls can touch."""
    angle, clearance = keys.track.contact_angle, keys.track.clearance
    if clearance is None:
        if angle is None:
            advice = 'add contact_angle = "45 deg", or of a deep-groove bearing e.g. clearance = { radial = "13 um" }'
            yield Fault(("track.contact_angle",), "an angle above 0 deg, below 90 deg", advice, "nothing")
        return
    if keys.track.lead != 0.0:
        advice = "play of a nut is smaller balls: write contact_angle, and errors.balls.oversize below zero"
        yield Fault(("track.clearance",), 'a bearing, lead = "0 mm"', advice, "a clearance of a nut")
    if angle is not None:
        advice = (
            "the balls rest at the angle that clearance and groove radii make: leave contact_angle out; play of a four-"
            "point bearing is errors.balls.oversize below zero"
        )
        yield Fault(("track.clearance",), "either contact_angle or clearance", advice, "both")
    given = [name for name in ("radial", "axial") if getattr(clearance, name) is not None]
    if len(given) != 1:
        yield Fault(
            ("track.clearance",), "one of radial and axial", "one follows from the other", "both" if given else "neither"
        )
    grooves = all((x.groove_radius is None) != (x.conformity is None) for x in (keys.screw, keys.nut))
    if len(given) == 1 and grooves and getattr(clearance, given[0]) >= 2.0 * centres_apart(keys):
        most = max(0.0, 2.0 * centres_apart(keys))
        advice = "there the balls would touch at 90 deg: check the unit, and the groove radii against the ball's"
        yield Fault((f"track.clearance.{given[0]}",), f"below {mm(most)} with these grooves", advice)


def _holding_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of a flange on a ring, flange keys without flange, and a former key together with the new one."""
    nut, former = keys.nut, keys.solid.nut_held
    if nut.held.at is not None and former is not None:
        yield Fault(("solid.nut_held",), "only nut.held.at", "solid.nut_held is its former name: leave it out", "both")
    if nut.flange is not None and keys.track.lead == 0.0:
        yield Fault(("nut.flange",), "a lead above 0 mm", "leave out the flange of a bearing's ring", "a flange")
    by_flange = nut.flange is not None and (nut.held.at or former or "flange face") == "flange face"
    for name in ("inner_diameter", "outer_diameter", "centring", "bolts", "at"):
        given = nut.held.at == "flange face" if name == "at" else name in nut.held.model_fields_set
        if given and not by_flange:
            advice = 'the annulus and the fit are those of a flange: give [nut.flange], and at = "flange face"'
            yield Fault((f"nut.held.{name}",), "a flange by which the nut is held", advice)
    if by_flange and nut.flange and nut.held.centring == "bonded" and nut.flange.centring == 0.0:
        advice = 'give the length of the fit next to the flange, e.g. nut.flange.centring = "10 mm"'
        yield Fault(("nut.held.centring",), '"free" without a fit', advice)


def _material_faults(keys: SceneKeys, part: str) -> Iterator[Fault]:
    """Yield faults of a part without Young's modulus or Poisson's ratio."""
    material = getattr(keys, part).material
    for name, unit in (("youngs_modulus", '"210 GPa"'), ("poissons_ratio", "0.28")):
        if getattr(material, name, None) is None and getattr(keys.material, name) is None:
            where = f"{part}.material.{name}"
            advice = f"write {name} = {unit} under [material] for all parts, or in {part}.material"
            yield Fault((where,), "a value here or under [material]", advice, "nothing")


def _ball_choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of the balls' number and arrangement."""
    balls, starts, ring = keys.balls, keys.track.starts, keys.track.lead == 0.0
    if ring and starts > 1:
        advice = "a bearing has one row: set starts = 1, or give a lead"
        yield Fault(("track.starts",), "1 for zero lead", advice)
    if balls.azimuths is not None and any(x is not None for x in (balls.count, balls.turns, balls.arcs)):
        advice = "leave out azimuths, or count with turns or arcs"
        yield Fault(("balls.azimuths",), "either azimuths, or count with turns", advice, "both")
        return
    if balls.azimuths is None and balls.count is None and balls.filling is None:
        advice = "write count and turns for balls spread evenly, or azimuths to list them"
        yield Fault(("balls.count",), "either azimuths, or count with turns", advice, "nothing")
        return
    if balls.arcs is not None:
        yield from _arc_faults(balls)
    elif balls.azimuths is None and balls.turns is None and not ring:
        advice = "write the number of turns that the balls of one start fill, e.g. turns = 2"
        yield Fault(("balls.turns",), "above 0", advice, "nothing")
    if ring and balls.turns is not None and balls.turns > 1.0:
        advice = "a bearing has one turn: leave turns out"
        yield Fault(("balls.turns",), "above 0, up to 1 for zero lead", advice)
    shares = starts * balls.circuits
    if balls.count is not None and balls.count % shares:
        near = max(shares, round(balls.count / shares) * shares)
        what = f"the {starts} starts" if balls.circuits == 1 else f"the {shares} circuits"
        advice = f"every {'start' if balls.circuits == 1 else 'circuit'} has as many balls: write e.g. count = {near}"
        yield Fault(("balls.count",), f"a multiple of {what}", advice)
    total = ball_total(balls, keys.track) if balls.azimuths is None else len(balls.azimuths) * starts
    yield from _listed_faults(keys, total)


def _arc_faults(balls: BallKeys) -> Iterator[Fault]:
    """Yield faults of angle ranges that are empty, out of order, or given with turns."""
    ends = [end for arc in balls.arcs or [] for end in arc]
    if balls.turns is not None:
        yield Fault(("balls.arcs",), "either turns or arcs", "arcs say how far the balls go: leave out turns", "both")
    elif any(b <= a for a, b in itertools.pairwise(ends)):
        advice = 'write them in order, e.g. arcs = [["-900 deg", "-180 deg"], ["180 deg", "900 deg"]]'
        yield Fault(("balls.arcs",), "ranges with growing ends that do not overlap", advice)


def _listed_faults(keys: SceneKeys, total: int) -> Iterator[Fault]:
    """Yield faults of too many balls, and of ball errors listed for unknown balls or twice."""
    if total > MAX_BALLS:
        allowed = f"at most {MAX_BALLS} balls"
        yield Fault(("balls.azimuths",), allowed, "list fewer azimuths", f"{total} balls")
    seen: set[int] = set()
    for text in keys.errors.balls.listed:
        where = (f"errors.balls.listed.{text}",)
        whole = text.isascii() and text.isdecimal() and len(text) <= 9
        if not whole or not 1 <= int(text) <= total:
            advice = f"balls are numbered from 1 to {total}, all balls of start 1 first"
            yield Fault(where, f"a ball number from 1 to {total}", advice, f"ball {text}")
        elif int(text) in seen:
            advice = f"ball {int(text)} is listed twice: keep one"
            yield Fault(where, "each ball once", advice, f"ball {text}")
        else:
            seen.add(int(text))


def _support_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of supports without freedoms, or that hold a freedom twice at one station."""
    taken: list[tuple[float, str, str]] = []
    for i, support in enumerate(keys.supports):
        given: list[tuple[str, str]] = [(name, f"supports[{i}].fix") for name in support.fix]
        given += [(name, f"supports[{i}].displace.{name}") for name in support.displace.given]
        if not given:
            advice = 'write fix = ["ux", ...] or displace = { ux = "0 mm" }, or delete the support'
            yield Fault((f"supports[{i}].fix",), "at least one of ux, uy, uz, rx, ry, rz", advice, "no freedom")
        for name, where in given:
            for at, other, first in taken:
                if other == name and abs(at - support.at) <= MERGE * (1.0 + TOLERANCE):
                    advice = f"{name} at {mm(at)} is already held by {first}: keep one of the two"
                    allowed = f"each freedom once per station (stations up to {mm(MERGE)} apart are one)"
                    yield Fault((where,), allowed, advice, f'"{name}" twice')
                    break
            else:
                taken.append((support.at, name, where))


def _said_twice(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of a diameter that is not twice the given radius, and of a count given with a filling."""
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
    """Yield faults of the balls' circuits and the gap between them."""
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
        if len(balls.arcs or []) > 1:
            yield from _circulating(keys, len(balls.arcs or []))
        return
    if listed:
        yield Fault(("balls.circuits",), f"1 together with {listed}", remedy)
    elif keys.track.lead == 0.0:
        yield Fault(("balls.circuits",), "1 for zero lead", "a bearing has one row")
    elif balls.circuit_gap is None:
        advice = "makers rarely print it: measure from ball to ball on a drawing, 0.3 to 1 turns are usual"
        value = f"{circuits} without circuit_gap"
        yield Fault(("balls.circuits",), "circuit_gap with it, the turns without balls between circuits", advice, value)
    yield from _circulating(keys, circuits)


def _operation(keys: SceneKeys) -> Iterator[Fault]:
    """Yield a fault if only one of viscosity ratio and contamination is given."""
    of = keys.operation
    if (of.viscosity_ratio is None) != (of.contamination is None):
        given, lacking = ("viscosity_ratio", "contamination")[:: 1 if of.contamination is None else -1]
        advice = f"a_ISO needs both: give {lacking} too, or leave {given} out"
        yield Fault((f"operation.{given}",), "with the other of both", advice, f"without {lacking}")


def _circulating(keys: SceneKeys, circuits: int) -> Iterator[Fault]:
    """Yield faults of [circulation] with another number of circuits than [balls], or with unequal arcs."""
    if keys.circulation is None and keys.time is None:
        return
    stated = 1 if keys.circulation is None else keys.circulation.circuits
    if stated != circuits:
        advice = f"[balls] has {circuits} circuits of each start: write circuits = {circuits} under [circulation]"
        yield Fault(("circulation.circuits", "circulation", "time"), str(circuits), advice, str(stated))
    spans = [end - start for start, end in keys.balls.arcs or []]
    if spans and max(spans) - min(spans) > 1e-9 * max(spans):
        advice = "circuits share the balls of their start equally; without [circulation] and [time] arcs may differ"
        yield Fault(("balls.arcs",), "arcs of one length where balls go round", advice)


def _preload(keys: SceneKeys) -> Iterator[Fault]:
    """Yield faults of a preload given in several forms or none, for a bearing by lead, or besides an oversize."""
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
