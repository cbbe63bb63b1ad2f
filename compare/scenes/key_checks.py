"""Checks of a scene file for keys that contradict or need each other, made before any geometry is built."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import pi
from typing import Any

from rollbench.compare.scenes.fault import TOLERANCE, Fault, length_text, value_at_path
from rollbench.compare.scenes.from_keys import groove_centre_distance, load_case_faults, loaded_ball_count
from rollbench.compare.scenes.keys import GrooveKeys
from rollbench.compare.scenes.schema import BallKeys, FrictionKeys, PreloadKeys, SceneKeys, SupportKeys
from rollbench.meshes.parts import Circulation, Motion, Operation, Time
from rollbench.meshes.ranges import MAX_BALLS
from rollbench.meshes.section import MERGE

#: Largest relative difference at which a diameter agrees with twice a radius that the file gives too.
SAME = 1e-9


def conflicting_key_faults(keys: SceneKeys, tables: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield the faults of a scene file's keys: keys that exclude or need each other, invalid counts and supports.

    ``tables``: tables of the file, which show whether a key is given.
    """
    bearing, balls = keys.track.lead == 0.0, keys.balls
    for part in ("screw", "nut", "balls") if None in (keys.material.youngs_modulus, keys.material.poissons_ratio) else ():
        yield from _missing_elastic_constant_faults(keys, part)
    kind = "bearing" if bearing else "ball screw"
    if keys.kind not in (None, kind):
        advice = f"correct kind or track.lead: a scene with a lead {'of' if bearing else 'above'} zero is a {kind}"
        yield Fault(("kind",), f'"{kind}" with this lead', advice)
    yield from groove_definition_faults(keys.screw, "screw")
    yield from groove_definition_faults(keys.nut, "nut")
    yield from _contact_angle_faults(keys)
    if keys.nut.flange is not None or keys.solid.nut_held is not None or "held" in tables.get("nut", {}):
        yield from _nut_fixing_faults(keys, tables)
    yield from _ball_arrangement_faults(keys)
    yield from support_faults(keys.supports)
    if keys.motion is not None:
        yield from zero_speed_faults(keys.motion)
    if keys.lubricant is not None and not bearing:
        advice = "leave [lubricant] out: the friction of a nut is given by [friction]"
        yield Fault(("lubricant",), "only for a bearing (track.lead of 0 mm)", advice, "a lubricant for a ball screw")
    if keys.friction is not None:
        yield from conflicting_friction_key_faults(keys.friction, tables)
    if keys.circulation is not None:
        yield from _circulation_faults(keys.circulation, bearing=bearing)
    if keys.time is not None:
        yield from simulation_time_faults(keys.time)
    stated = ("track.pitch_diameter", keys.track.pitch_diameter, keys.track.pitch_radius)
    for where, diameter, radius in (stated, ("balls.diameter", balls.diameter, balls.radius)):
        if diameter is not None and abs(diameter - 2.0 * radius) > SAME * radius:
            allowed = f"{length_text(2.0 * radius)}, twice the radius that is given too"
            yield Fault((where,), allowed, "leave one of the two out")
    if balls.count is not None and balls.filling is not None:
        yield Fault(("balls.filling",), "either count or filling", "leave one of the two out", "both count and filling")
    if balls.circuits > 1 or any(x is not None for x in (balls.circuit_gap, balls.azimuths, balls.arcs)):
        yield from _circuit_faults(keys)
    if keys.preload is not None:
        yield from _preload_faults(keys, keys.preload)
    if keys.operation != Operation():
        yield from _life_factor_faults(keys.operation)
    if keys.cases:
        yield from load_case_faults(keys)


def zero_speed_faults(motion: Motion) -> Iterator[Fault]:
    """Yield a fault if the angular speed of the rotating part is zero."""
    if motion.speed == 0.0:
        advice = "give the speed at which the part turns: friction at rest may have any value up to its limit"
        yield Fault(("motion.speed",), "any angular speed but zero", advice)


def _circulation_faults(circulation: Circulation, *, bearing: bool) -> Iterator[Fault]:
    """Yield the faults of the table ``[circulation]`` (ball circuits); ``bearing``: whether the scene is a bearing."""
    if bearing:
        advice = "leave [circulation] out: the balls of a bearing go round its one turn"
        yield Fault(("circulation",), "only with a lead above 0 mm", advice, "a circulation for a bearing")
    if circulation.gap is not None and circulation.filling is not None:
        allowed, advice = "either gap or filling", "leave one of the two out: one follows from the other"
        yield Fault(("circulation.gap",), allowed, advice, "both gap and filling")


def simulation_time_faults(time: Time) -> Iterator[Fault]:
    """Yield a fault unless the table [time] of a simulation states either an angle or a duration."""
    if (time.angle is None) == (time.duration is None):
        value = "neither" if time.angle is None else "both angle and duration"
        advice = 'write one of them, e.g. angle = "360 deg" or duration = "1 s"'
        yield Fault(("time.angle", "time"), "either angle or duration", advice, value)


def conflicting_friction_key_faults(friction: FrictionKeys, tables: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield the faults of [friction]: a groove without coefficient, or the former key ``coupling`` beside new keys.

    The new keys, which replace ``coupling``, are ``feedback`` and ``neighbours``. ``tables``: tables of the file.
    """
    if friction.coefficient is None and None in (friction.screw, friction.nut):
        advice = "write e.g. coefficient = 0.1, or a coefficient for each groove, screw and nut"
        yield Fault(("friction.coefficient",), "a number from 0 to 2", advice, "nothing")
    given = (name for name in ("feedback", "neighbours") if value_at_path(tables, f"friction.{name}") is not None)
    if friction.coupling and any(given):
        advice = "leave coupling out: it is the former key for feedback and neighbours"
        yield Fault(("friction.coupling",), "only without feedback and neighbours", advice)


def groove_definition_faults(groove: GrooveKeys, table: str) -> Iterator[Fault]:
    """Yield a fault unless a groove has either a radius or a conformity; ``table``: name of its table in the file."""
    if (groove.groove_radius is None) == (groove.conformity is None):
        given = "neither" if groove.conformity is None else "both groove_radius and conformity"
        advice = "give one of the two: groove_radius = conformity x ball diameter"
        yield Fault((f"{table}.groove_radius",), "either groove_radius or conformity", advice, given)


def _contact_angle_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for the nominal contact angle, and for the clearance that may replace it in a bearing.

    A clearance is allowed only for a bearing, and only without a contact angle. It must be either radial or axial, and so
    small that the balls can touch both grooves.
    """
    angle, clearance = keys.track.contact_angle, keys.track.clearance
    if angle is not None and angle >= 0.5 * pi and keys.track.lead != 0.0:
        advice = 'check the angle: only the washers of a thrust ball bearing, lead = "0 mm", have a contact angle of 90 deg'
        yield Fault(("track.contact_angle",), "above 0 deg, below 90 deg for a screw", advice)
    if clearance is None:
        if angle is None:
            advice = 'add e.g. contact_angle = "45 deg", or clearance = { radial = "13 um" } for a deep-groove bearing'
            yield Fault(("track.contact_angle",), "an angle above 0 deg, up to 90 deg", advice, "nothing")
        return
    if keys.track.lead != 0.0:
        advice = "write contact_angle, and the nut's play as errors.balls.oversize below zero"
        yield Fault(("track.clearance",), 'only for a bearing, lead = "0 mm"', advice, "a clearance of a nut")
    if angle is not None:
        advice = (
            "leave contact_angle out: it follows from clearance and groove radii; write play of a four-point bearing as "
            "errors.balls.oversize below zero"
        )
        yield Fault(("track.clearance",), "either contact_angle or clearance", advice, "both contact_angle and clearance")
    given = [name for name in ("radial", "axial") if getattr(clearance, name) is not None]
    if len(given) != 1:
        value = "both radial and axial" if given else "neither"
        advice = "give one of the two: the other follows from it"
        yield Fault(("track.clearance",), "either radial or axial clearance", advice, value)
    grooves = all((x.groove_radius is None) != (x.conformity is None) for x in (keys.screw, keys.nut))
    if len(given) == 1 and grooves and getattr(clearance, given[0]) >= 2.0 * groove_centre_distance(keys):
        most = max(0.0, 2.0 * groove_centre_distance(keys))
        advice = "check the unit and the groove radii: with this clearance the contact angle would reach 90 deg"
        yield Fault((f"track.clearance.{given[0]}",), f"below {length_text(most)} with these grooves", advice)


def _nut_fixing_faults(keys: SceneKeys, tables: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield the faults of the keys that state where the nut is fixed: at its flange's face or at another surface.

    The keys for a fixing at the flange are allowed only for a nut that has a flange and is fixed at its face. ``tables``:
    tables of the file.
    """
    nut, former = keys.nut, keys.solid.nut_held
    if nut.held.at is not None and former is not None:
        advice = "leave solid.nut_held out: it is the former name of nut.held.at"
        yield Fault(("solid.nut_held",), "only without nut.held.at", advice)
    if nut.flange is not None and keys.track.lead == 0.0:
        advice = "leave the flange out: the outer ring of a bearing has none"
        yield Fault(("nut.flange",), "only with a lead above 0 mm", advice, "a flange for a bearing")
    by_flange = nut.flange is not None and (nut.held.at or former or "flange face") == "flange face"
    for name in ("inner_diameter", "outer_diameter", "centring", "bolts", "at"):
        given = nut.held.at == "flange face" if name == "at" else value_at_path(tables, f"nut.held.{name}") is not None
        if given and not by_flange:
            advice = 'give [nut.flange] and nut.held.at = "flange face", or leave this key out'
            yield Fault((f"nut.held.{name}",), "only for a nut that is fixed at the face of its flange", advice)
    if by_flange and nut.flange and nut.held.centring == "bonded" and nut.flange.centring == 0.0:
        advice = 'give the length of the fit next to the flange, e.g. nut.flange.centring = "10 mm"'
        yield Fault(("nut.held.centring",), '"free" for a flange without centring fit', advice)


def _missing_elastic_constant_faults(keys: SceneKeys, part: str) -> Iterator[Fault]:
    """Yield the faults of a part for which the file states no Young's modulus or no Poisson's ratio.

    ``part``: name of the part's table: screw, nut or balls.
    """
    material = getattr(keys, part).material
    for name, unit in (("youngs_modulus", '"210 GPa"'), ("poissons_ratio", "0.28")):
        if getattr(material, name, None) is None and getattr(keys.material, name) is None:
            where = f"{part}.material.{name}"
            advice = f"write {name} = {unit} under [material] for all parts, or in {part}.material"
            yield Fault((where,), "a value in this table or under [material]", advice, "nothing")


def _ball_arrangement_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for number and positions of the balls: count and turns, arcs, or azimuths."""
    balls, starts, ring = keys.balls, keys.track.starts, keys.track.lead == 0.0
    if ring and starts > 1:
        advice = "write starts = 1, or give a lead: a bearing has one row of balls"
        yield Fault(("track.starts",), "1 for a bearing, whose lead is zero", advice)
    if balls.azimuths is not None and any(x is not None for x in (balls.count, balls.turns, balls.arcs)):
        other = next(name for name in ("count", "turns", "arcs") if getattr(balls, name) is not None)
        advice = "leave out azimuths, or else count, turns and arcs"
        yield Fault(("balls.azimuths",), "either azimuths, or count with turns", advice, f"both azimuths and {other}")
        return
    if balls.azimuths is None and balls.count is None and balls.filling is None:
        advice = "write count and turns for evenly spread balls, or list the azimuths of all balls"
        yield Fault(("balls.count",), "either azimuths, or count with turns", advice, "nothing")
        return
    if balls.arcs is not None:
        yield from _ball_arc_faults(balls)
    elif balls.azimuths is None and balls.turns is None and not ring:
        advice = "write the number of turns that the balls of one start fill, e.g. turns = 2"
        yield Fault(("balls.turns",), "a number above 0", advice, "nothing")
    if ring and balls.turns is not None and balls.turns > 1.0:
        advice = "leave turns out: the balls of a bearing fill one turn"
        yield Fault(("balls.turns",), "above 0, up to 1 for a bearing, whose lead is zero", advice)
    shares = starts * balls.circuits
    if balls.count is not None and balls.count % shares:
        near = max(shares, round(balls.count / shares) * shares)
        groups = "starts" if balls.circuits == 1 else "circuits"
        advice = f"write e.g. count = {near}, so that all {groups} have equally many balls"
        yield Fault(("balls.count",), f"a multiple of {shares}, the number of {groups}", advice)
    total = balls.count or loaded_ball_count(balls, keys.track)
    if total > MAX_BALLS:
        yield Fault(("balls.azimuths",), f"at most {MAX_BALLS} balls", "list fewer azimuths", f"{total} balls")
    if keys.errors.balls.listed:
        yield from _listed_ball_error_faults(keys.errors.balls.listed, total)


def _ball_arc_faults(balls: BallKeys) -> Iterator[Fault]:
    """Yield a fault if angle ranges filled with balls are empty or out of order, or are given in addition to ``turns``."""
    ends = [end for arc in balls.arcs or [] for end in arc]
    if balls.turns is not None:
        yield Fault(("balls.arcs",), "either turns or arcs", "leave one of the two out", "both turns and arcs")
    elif any(b <= a for a, b in itertools.pairwise(ends)):
        advice = 'write the ranges in order, e.g. arcs = [["-900 deg", "-180 deg"], ["180 deg", "900 deg"]]'
        yield Fault(("balls.arcs",), "angle ranges in ascending order that do not overlap", advice)


def _listed_ball_error_faults(listed: Iterable[str], ball_count: int) -> Iterator[Fault]:
    """Yield a fault for each radius error that is listed for a ball that does not exist, or listed twice.

    ``listed``: numbers of the balls, as the file states them; ``ball_count``: number of balls of the scene.
    """
    seen: set[int] = set()
    for text in listed:
        where = (f"errors.balls.listed.{text}",)
        whole = text.isascii() and text.isdecimal() and len(text) <= 9
        if not whole or not 1 <= int(text) <= ball_count:
            advice = f"correct the number: the scene has {ball_count} balls, all balls of the first start first"
            yield Fault(where, f"a ball number from 1 to {ball_count}", advice, f"ball {text}")
        elif int(text) in seen:
            advice = f"keep one of the two errors of ball {int(text)}"
            yield Fault(where, "each ball once", advice, f"ball {int(text)} twice")
        else:
            seen.add(int(text))


def support_faults(supports: Sequence[SupportKeys]) -> Iterator[Fault]:
    """Yield the faults of supports that fix no degree of freedom, or one that a support at the same position fixes too."""
    taken: list[tuple[float, str, str]] = []
    for i, support in enumerate(supports):
        given: list[tuple[str, str]] = [(name, f"supports[{i}].fix") for name in support.fix]
        given += [(name, f"supports[{i}].displace.{name}") for name in support.displace.given]
        if not given:
            advice = 'write fix = ["ux", ...] or displace = { ux = "0 mm" }, or delete the support'
            yield Fault((f"supports[{i}].fix",), "at least one of ux, uy, uz, rx, ry, rz", advice, "no degree of freedom")
        for name, where in given:
            for at, other, first in taken:
                if other == name and abs(at - support.at) <= MERGE * (1.0 + TOLERANCE):
                    advice = f"keep one of the two: {name} at {length_text(at)} is already fixed by {first}"
                    allowed = f"each degree of freedom once per position ({length_text(MERGE)} or less apart count as one)"
                    yield Fault((where,), allowed, advice, f'"{name}" twice')
                    break
            else:
                taken.append((support.at, name, where))


def _circuit_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for the number of ball circuits and the gap between them."""
    balls, circuits = keys.balls, keys.balls.circuits
    listed = next((name for name in ("azimuths", "arcs") if getattr(balls, name) is not None), "")
    remedy = f"leave this key out: {listed} already state where the balls are"
    for name in ("filling", "circuit_gap") if listed else ():
        if getattr(balls, name) is not None:
            advice = "write count instead" if (name, listed) == ("filling", "arcs") else remedy
            yield Fault((f"balls.{name}",), f"only without {listed}", advice)
    if circuits == 1:
        if balls.circuit_gap is not None and not listed:
            advice = "write the number of circuits, or leave circuit_gap out"
            yield Fault(("balls.circuits",), "2 or more together with circuit_gap", advice, "one circuit")
        if len(balls.arcs or []) > 1:
            yield from _circulating_ball_faults(keys, len(balls.arcs or []))
        return
    if listed:
        yield Fault(("balls.circuits",), f"1 together with {listed}", remedy)
    elif keys.track.lead == 0.0:
        advice = "leave circuits out: a bearing has one row of balls"
        yield Fault(("balls.circuits",), "1 for a bearing, whose lead is zero", advice)
    elif balls.circuit_gap is None:
        advice = "write e.g. circuit_gap = 0.5, measured on a drawing from ball to ball; 0.3 to 1 turns are usual"
        value = f"{circuits} circuits without circuit_gap"
        allowed = "only together with circuit_gap, the number of turns without balls between circuits"
        yield Fault(("balls.circuits",), allowed, advice, value)
    yield from _circulating_ball_faults(keys, circuits)


def _life_factor_faults(of: Operation) -> Iterator[Fault]:
    """Yield a fault if only one of viscosity ratio and contamination is given; the life factor a_ISO needs both."""
    if (of.viscosity_ratio is None) != (of.contamination is None):
        both = "viscosity_ratio", "contamination"
        given, lacking = both if of.contamination is None else both[::-1]
        advice = f"give {lacking} too, or leave {given} out: the life factor a_ISO needs both"
        yield Fault((f"operation.{given}",), f"only together with {lacking}", advice, f"{given} without {lacking}")


def _circulating_ball_faults(keys: SceneKeys, circuits: int) -> Iterator[Fault]:
    """Yield the faults of ball circuits where the scene file has a table [circulation] or [time].

    Faults are different numbers of circuits in [circulation] and [balls], and angle ranges of balls that are not equally
    long. ``circuits``: number of circuits of each start according to [balls].
    """
    if keys.circulation is None and keys.time is None:
        return
    stated = 1 if keys.circulation is None else keys.circulation.circuits
    if stated != circuits:
        advice = f"write circuits = {circuits} under [circulation]"
        allowed = f"{circuits} circuits of each start, as under [balls]"
        yield Fault(("circulation.circuits", "circulation", "time"), allowed, advice, str(stated))
    spans = [end - start for start, end in keys.balls.arcs or []]
    if spans and max(spans) - min(spans) > 1e-9 * max(spans):
        advice = "make the arcs equally long, or leave [circulation] and [time] out: circuits have equally many balls"
        yield Fault(("balls.arcs",), "arcs of equal length together with [circulation] or [time]", advice)


def _preload_faults(keys: SceneKeys, preload: PreloadKeys) -> Iterator[Fault]:
    """Yield the faults of [preload]: not exactly one key, a lead offset of a bearing, or an oversize stated twice."""
    given = [name for name in ("force", "oversize", "lead_offset") if getattr(preload, name) is not None]
    if len(given) != 1:
        where = (f"preload.{given[0] if given else 'force'}", "preload")
        advice = "keep one of these keys" if given else 'write e.g. force = "500 N"'
        yield Fault(where, "one of force, oversize and lead_offset", advice, " and ".join(given) or "none of these keys")
    if preload.lead_offset is not None and keys.track.lead == 0.0:
        advice = "describe the rows of a bearing as [[sets]] with an offset"
        yield Fault(("preload.lead_offset",), "only with a lead above 0 mm", advice)
    if preload.lead_offset is None and keys.errors.balls.oversize != 0.0:
        advice = "leave one of the two out: [preload] determines the oversize"
        yield Fault(("errors.balls.oversize",), "0 um together with [preload]", advice)
