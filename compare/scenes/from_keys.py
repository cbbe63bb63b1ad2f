"""Build parts and load cases from the validated keys of a scene file, and check the keys of load cases."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import cos, floor, hypot, pi, sin
from typing import Any

import numpy as np

from rollbench.compare.errors import escape_unprintable
from rollbench.compare.measure import error_percent
from rollbench.compare.scenes import schema
from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.compare.scenes.fault import Fault, length_text, raise_scene_error_for_faults
from rollbench.compare.scenes.keys import MaterialKeys, record_from_keys
from rollbench.meshes import parts
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.numerics import brentq
from rollbench.meshes.ranges import ShareOfLoadRating
from rollbench.meshes.section import MERGE
from rollbench.meshes.stated import evenly_spaced_azimuths, free_contact_angle


def scene_from_keys(keys: schema.SceneKeys, name: str) -> parts.Scene:
    """Return the scene ``name`` (ball screw or bearing) from the validated keys of its file."""
    nut, balls, errors, formerly_held = keys.nut, keys.balls, keys.errors, keys.solid.nut_held
    former = (
        () if formerly_held is None else (f'The former key solid.nut_held = "{formerly_held}" is read as nut.held.at.',)
    )
    listed = tuple(sorted((int(number), error) for number, error in (errors.balls.listed or {}).items()))
    clearance = keys.track.clearance
    oversize = errors.balls.oversize + (0.0 if clearance is None else oversize_by_press_fit(clearance))
    return record_from_keys(
        parts.Scene,
        keys,
        name=name,
        title=escape_unprintable(keys.title),
        source=escape_unprintable(keys.source),
        assumed=(*map(escape_unprintable, keys.assumed), *former),
        track=record_from_keys(parts.Track, keys.track) if clearance is None else _track_with_clearance(keys, clearance),
        screw=record_from_keys(
            parts.Screw,
            keys.screw,
            groove_radius=keys.screw.radius_for(balls.radius),
            material=material_from_keys(keys.screw.material, keys.material),
        ),
        nut=record_from_keys(
            parts.Nut,
            nut,
            groove_radius=nut.radius_for(balls.radius),
            material=material_from_keys(nut.material, keys.material),
            flange=None if nut.flange is None else _flange_from_keys(nut.flange, nut),
        ),
        balls=parts.Balls(
            balls.radius, material_from_keys(balls.material, keys.material), _ball_azimuths(balls, keys.track)
        ),
        errors=record_from_keys(
            parts.Errors,
            errors,
            balls=record_from_keys(parts.BallErrors, errors.balls, oversize=oversize, listed=listed),
            lead_offset=0.0 if keys.preload is None else keys.preload.lead_offset or 0.0,
        ),
        supports=tuple(record_from_keys(parts.Support, support) for support in keys.supports),
        solid=replace(keys.solid, nut_held=nut.held.at or formerly_held),
        friction=None if keys.friction is None else friction_from_keys(keys.friction),
    )


def _track_with_clearance(keys: schema.SceneKeys, clearance: schema.ClearanceKeys) -> parts.Track:
    """Return the path of the balls of a bearing with one arc per groove, whose contact angle follows from the clearance."""
    apart = groove_centre_distance(keys)
    radial = None if clearance.radial is None else max(0.0, clearance.radial)
    angle = free_contact_angle(apart, radial, clearance.axial)
    return record_from_keys(parts.Track, keys.track, contact_angle=angle, arcs="+z")


def oversize_by_press_fit(clearance: schema.ClearanceKeys) -> float:
    """Return the oversize of the ball radius [m] that presses balls like a negative radial clearance; 0 if it is positive.

    The clearance is taken across the bearing, through two balls with two contacts each: a quarter of it for each radius.
    """
    return max(0.0, -(clearance.radial or 0.0)) / 4.0


def groove_centre_distance(keys: schema.SceneKeys) -> float:
    """Return the distance [m] between the centres of the screw's and the nut's groove arcs when a ball touches both."""
    return keys.screw.radius_for(keys.balls.radius) + keys.nut.radius_for(keys.balls.radius) - 2.0 * keys.balls.radius


def _flange_from_keys(flange: schema.FlangeKeys, nut: schema.NutKeys) -> parts.Flange:
    """Return the flange of a nut from the keys of both.

    The flange may be fixed at its whole face towards the rest of the nut, or at the annulus whose diameters are given.
    """
    held = nut.held
    low, high = held.inner_diameter or nut.outer_diameter, held.outer_diameter or flange.diameter
    seat, bonded = (0.5 * low, 0.5 * high), held.centring == "bonded"
    return record_from_keys(parts.Flange, flange, seat=seat, bonded=bonded, bolts=held.bolts)


def friction_from_keys(keys: schema.FrictionKeys) -> parts.Friction:
    """Return friction coefficients, and whether friction changes the contact loads, from the table [friction] of a file."""
    screw, nut = (keys.coefficient if given is None else given for given in (keys.screw, keys.nut))
    assumed, former = tuple(map(escape_unprintable, keys.assumed)), {}
    if keys.coupling is not None:
        former = {"feedback": keys.coupling == "ball", "neighbours": keys.coupling == "balls"}
        read = ", ".join(f"{name} = {str(value).lower()}" for name, value in former.items())
        assumed += (f'The former key coupling = "{keys.coupling}" is read as {read}.',)
    return record_from_keys(parts.Friction, keys, screw=screw, nut=nut, assumed=assumed, **former)


def material_from_keys(keys: MaterialKeys | None, default: MaterialKeys) -> parts.Material:
    """Return the material of a part from its keys, completed from the table [material] of the scene file.

    ``keys``: material in the part's table, None if it has none; ``default``: table [material], which gives missing values.
    """
    keys = keys or default
    modulus = default.youngs_modulus if keys.youngs_modulus is None else keys.youngs_modulus
    ratio = default.poissons_ratio if keys.poissons_ratio is None else keys.poissons_ratio
    if modulus is None or ratio is None:  # conflicting_key_faults has refused this
        raise AssertionError("a material without Young's modulus or Poisson's ratio")
    return parts.Material(modulus, ratio)


def _ball_azimuths(balls: schema.BallKeys, track: schema.TrackKeys) -> tuple[float, ...]:
    """Return the azimuths [rad] of the balls in one start of the thread, from the keys of balls and track.

    The file lists them (``balls.azimuths``); or the balls are spread evenly over the angle ranges ``balls.arcs``, or over
    the turns of each circuit. Circuits and the gaps between them are centred on the nut.
    """
    if balls.azimuths is not None:
        return balls.azimuths
    if balls.arcs is None:
        n = ball_count_of_circuit(balls, track)
        return evenly_spaced_azimuths(n, balls.turns or 1.0, track.phase, balls.circuits, balls.circuit_gap or 0.0)
    n = (balls.count or 0) // track.starts
    ends = np.array(balls.arcs)
    fill = np.concatenate([[0.0], np.cumsum(ends[:, 1] - ends[:, 0])])
    at = (np.arange(n) + 0.5) / n * fill[-1]
    arc = np.searchsorted(fill, at, side="right") - 1
    return tuple(float(x) for x in track.phase + ends[arc, 0] + at - fill[arc])


def ball_count_of_circuit(balls: schema.BallKeys, track: schema.TrackKeys) -> int:
    """Return the number of balls of one circuit: the number of all balls divided by starts and circuits.

    If the file does not state the number of balls, it follows from ``balls.filling``, the fraction of the turns that the
    balls would fill if they touched; it is at least one.
    """
    if balls.count is not None:
        return balls.count // (track.starts * balls.circuits)
    touching = angle_of_touching_balls(track.pitch_radius, track.lead, 2.0 * balls.radius)
    return max(1, floor((balls.filling or 0.0) * 2.0 * pi * (balls.turns or 1.0) / touching + 1e-9))


def angle_of_touching_balls(pitch_radius: float, lead: float, ball_diameter: float) -> float:
    """Return the difference in azimuth phi [rad] between the centres of touching balls on a helix.

    The chord between the centres is the ball diameter d: d^2 = (2 R sin(phi/2))^2 + (lead phi / 2 pi)^2. The result is pi
    if even the chord of half a turn is shorter than d.

    Parameters
    ----------
    pitch_radius
        Pitch radius R [m].
    lead
        Lead [m].
    ball_diameter
        Ball diameter d [m].
    """

    def chord_minus_diameter(angle: float) -> float:
        """Return the chord between two ball centres whose azimuths differ by ``angle`` [rad], less a ball diameter [m]."""
        return hypot(2.0 * pitch_radius * sin(angle / 2.0), lead * angle / (2.0 * pi)) - ball_diameter

    return float(brentq(chord_minus_diameter, 0.0, pi, xtol=1e-14)) if chord_minus_diameter(pi) > 0.0 else pi


def loaded_ball_count(balls: schema.BallKeys, track: schema.TrackKeys) -> int:
    """Return the number of loaded balls in all starts and circuits together."""
    if balls.azimuths is not None:
        return len(balls.azimuths) * track.starts
    return balls.count or ball_count_of_circuit(balls, track) * balls.circuits * track.starts


# --- preload of one nut, converted to the ball oversize that causes it


def ball_oversize_for_preload(scene: parts.Scene, force: float) -> float:
    """Return the oversize e of the ball radius [m] that causes a given axial preload between rigid nut and rigid screw.

    Each of the n balls has four contacts, which all carry Q = force / (n sin beta cos alpha), with the contact angle beta
    and the lead angle alpha. The approaches of two opposite contacts of a ball, one on the screw and one on the nut, add up
    to twice the oversize: 2 e = (C_S + C_N) Q^(2/3), with the Hertz constants C_S of the contact on the screw and C_N of
    that on the nut [m N^(-2/3)] at the nominal contact angle. The formula is valid if e is small against the distance
    between the centres of ball and groove arc, so that the contact angle hardly changes (the error is one per cent of the
    force for an oversize of 7 um and a distance of 0.5 mm).

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    force
        Preload [N]: the axial force in each of the two directions, on the left and on the right flanks, without external
        load.
    """
    from rollbench.lowfi.statics.contacts import hertz_without_errors

    beta, alpha = scene.track.contact_angle, lead_angle(scene.track)
    each = force / (scene.ball_count * sin(beta) * cos(alpha))
    constants = hertz_without_errors(scene).C
    pair = float(constants[0] + constants[3])
    return float(0.5 * pair * each ** (2.0 / 3.0))


def preload_force_and_rating_text(scene: parts.Scene, force_or_share: float | ShareOfLoadRating) -> tuple[float, str]:
    """Return a preload [N], and a text on the load rating from which it was computed.

    ``force_or_share``: the preload as a force [N], for which the text is empty; or as a fraction of the dynamic load rating
    of the nut or bearing ``scene``, for which the text states the rating in brackets.
    """
    if not isinstance(force_or_share, ShareOfLoadRating):
        return force_or_share, ""
    from rollbench.lowfi.rating.life import dynamic_rating

    C = dynamic_rating(scene)
    percent = float(error_percent(force_or_share.share * C, 0.0, C))
    return force_or_share.share * C, f" ({percent:.3g} % of the dynamic load rating as computed, {C:.4g} N)"


def with_preload_as_oversize(scene: parts.Scene, keys: schema.PreloadKeys | None) -> parts.Scene:
    """Return the scene with the preload of its file's table [preload], converted to an oversize of the balls.

    ``keys``: keys of the table. The scene is returned unchanged if these are None or state a lead offset. If they state a
    force, a sentence on its conversion to an oversize is added to the scene's assumptions.
    """
    if keys is None or keys.lead_offset is not None:
        return scene
    size, assumed = keys.oversize or 0.0, scene.assumed
    if keys.force is not None:
        force, of = preload_force_and_rating_text(scene, keys.force)
        size = ball_oversize_for_preload(scene, force)
        assumed += (
            f"The preload of {force:g} N{of} was turned into an oversize of {1e6 * size:.3g} um in ball radius, by Hertz "
            "contacts between a rigid screw and a rigid nut; elastic ones give way, so that less than it is left.",
        )
    balls = replace(scene.errors.balls, oversize=size)
    return replace(scene, errors=replace(scene.errors, balls=balls), assumed=assumed)


#: Largest allowed deviation of the sum of shares from 1, since files state shares with a few digits.
ROUNDED = 1e-6


def with_load_cases(
    scene: parts.Scene | Assembly,
    load_case_keys: Sequence[schema.LoadCaseKeys],
    tables: Mapping[str, Any],
    file_name: str,
    faults_of_scene: Callable[[Any], Iterable[Fault]],
) -> DutyCycle:
    """Return the duty cycle of a scene with its file's load cases, of which there is at least one.

    The share of a load case is its fraction of the revolutions of the cycle. If the file states times instead of shares,
    the revolutions of a load case are its time multiplied by its absolute speed.

    Parameters
    ----------
    scene
        Scene under the loads that the file states outside its load cases.
    load_case_keys
        Validated keys of the load cases.
    tables
        Tables of the file as read from TOML, for the faulty values in messages.
    file_name
        Name of the file in messages.
    faults_of_scene
        Function that returns the faults of a scene, called for the scene of each load case.

    Raises
    ------
    SceneError
        For the faults of the scene in any load case.
    """
    turned = [0.0 if k.time is None else k.time * abs(k.speed or 0.0) for k in load_case_keys]
    whole, time = sum(turned), sum(k.time or 0.0 for k in load_case_keys)
    shares = [k.share or 0.0 for k in load_case_keys] if whole == 0.0 else [x / whole for x in turned]
    speed = whole / time if whole else None if scene.motion is None else abs(scene.motion.speed)
    cases = (
        LoadCase(k.name, share, k.speed, _scene_under_load_case(scene, k), k.time)
        for k, share in zip(load_case_keys, shares, strict=True)
    )
    cycle = DutyCycle(scene, tuple(cases), speed)
    faults = [(fault, k) for k, case in enumerate(cycle.cases) for fault in faults_of_scene(case.scene)]
    raise_scene_error_for_faults(file_name, tables, [fault_with_keys_of_load_case(*x) for x in faults])
    return cycle


def _scene_under_load_case(scene: parts.Scene | Assembly, keys: schema.LoadCaseKeys) -> parts.Scene | Assembly:
    """Return the scene under the load case ``keys``: with the loads, displacements, speed and oversize that it states.

    Its name is SCENE-CASE, so that stored runs and files of each load case have separate names.
    """
    motion = scene.motion
    if keys.speed is not None:
        motion = parts.Motion(keys.speed) if motion is None else replace(motion, speed=keys.speed)
    case = replace(
        scene,
        name=f"{scene.name}-{keys.name}",
        loads=scene.loads if keys.loads is None else keys.loads,
        supports=tuple(_displaced_support(s, keys) for s in scene.supports),
        motion=motion,
    )
    if isinstance(case, parts.Scene):
        return replace(case, errors=_errors_under_load_case(case, keys))
    sets = tuple(
        replace(one, parts=replace(part, errors=_errors_under_load_case(part, keys)))
        if isinstance(part := one.parts, parts.Scene)
        else one
        for one in case.sets
    )
    of_case = getattr(keys, "housings", ())
    loaded: dict[str, dict[str, Any]] = {h.name: {"force": h.force, "moment": h.moment} for h in of_case}
    housings = (replace(h, **loaded.get(h.name, {})) for h in case.housings)
    return replace(case, sets=sets, housings=tuple(housings))


def _errors_under_load_case(scene: parts.Scene, keys: schema.LoadCaseKeys) -> parts.Errors:
    """Return the manufacturing errors of a scene, with the ball oversize of the load case ``keys`` if it states one."""
    oversize = scene.errors.balls.oversize if keys.oversize is None else keys.oversize
    return replace(scene.errors, balls=replace(scene.errors.balls, oversize=oversize))


def _displaced_support(support: parts.Support, keys: schema.LoadCaseKeys) -> parts.Support:
    """Return a support with the displacements that the load case ``keys`` prescribes at the support's position."""
    here = (other.displace.given for other in keys.supports if abs(other.at - support.at) <= MERGE)
    moved = {name: value for given in here for name, value in given.items()}
    return replace(support, fixed=tuple((name, moved.get(name, value)) for name, value in support.fixed))


def load_case_faults(keys: schema.SceneKeys | schema.ShaftSceneKeys) -> Iterator[Fault]:
    """Yield the faults of the load cases of a scene file: names, fractions of revolutions, times, displaced supports."""
    names = [case.name for case in keys.cases]
    tracks = [keys.track] if isinstance(keys, schema.SceneKeys) else [s.track for s in keys.sets if s.track is not None]
    pressed = any(oversize_by_press_fit(track.clearance) for track in tracks if track.clearance is not None)
    for k, case in enumerate(keys.cases):
        where = f"cases[{k}]"
        if pressed and case.oversize is not None:
            advice = "write clearance = 0 in the scene, and an oversize of a quarter of the press fit in each load case"
            yield Fault((f"{where}.oversize",), "nothing together with a negative track.clearance.radial", advice)
        if not re.fullmatch(r"[\w.-]{1,60}", case.name):
            advice = 'write e.g. name = "rapid-travel": the name becomes a part of file names'
            yield Fault((f"{where}.name",), "up to 60 letters, digits, . _ and -", advice)
        if case.name in names[:k]:
            yield Fault((f"{where}.name",), "a unique name", "rename one of the two: the name identifies results")
        yield from _load_case_share_faults(case, where)
        yield from _load_case_support_faults(keys, case, where)
    if any((case.share is None) == (case.time is None) for case in keys.cases):
        return
    timed = [k for k, case in enumerate(keys.cases) if case.time is not None]
    shared = [k for k, case in enumerate(keys.cases) if case.share]
    if timed and shared:
        advice = "give each load case a share, or each a time and a speed; those checked only statically have share = 0"
        yield Fault((f"cases[{shared[0]}].share",), "0 together with load cases that have a time", advice)
    elif timed and not any(keys.cases[k].time for k in timed):
        yield Fault((f"cases[{timed[0]}].time",), "above 0 s in at least one load case", "correct one of the times")
    elif not timed and abs(sum(case.share or 0.0 for case in keys.cases) - 1.0) > ROUNDED:
        total = sum(case.share or 0.0 for case in keys.cases)
        advice = "write the fractions of all revolutions, which sum to 1; 0 for a load case checked only statically"
        yield Fault((f"cases[{(shared or [0])[-1]}].share",), "shares that sum to 1", advice, f"a sum of {total:.7g}")


def _load_case_share_faults(case: schema.LoadCaseKeys, case_path: str) -> Iterator[Fault]:
    """Yield a fault unless a load case has either a fraction of the revolutions (``share``), or both time and speed.

    ``case_path``: path of the case in the file, such as ``cases[0]``.
    """
    if (case.share is None) == (case.time is None):
        given = "neither" if case.share is None else "both share and time"
        advice = 'write share = 0.5, or time = "20 s" with speed = "200 rpm"'
        yield Fault((f"{case_path}.share",), "either share or time", advice, given)
    elif case.time is not None and case.speed is None:
        advice = 'write e.g. speed = "200 rpm": the share of the revolutions follows from time and speed'
        yield Fault((f"{case_path}.speed",), "a speed together with a time", advice, "nothing")
    if case.speed == 0.0:
        advice = "write share = 0 in place of the speed for a load case at rest, which is checked statically only"
        yield Fault((f"{case_path}.speed",), "any angular speed but zero", advice)


def _load_case_support_faults(
    keys: schema.SceneKeys | schema.ShaftSceneKeys, case: schema.LoadCaseKeys, case_path: str
) -> Iterator[Fault]:
    """Yield the faults of the support displacements that a load case prescribes.

    Faults are a position without support, a degree of freedom that the scene's support does not fix, and two displacements
    of the same degree of freedom. ``keys``: keys of the scene; ``case``: keys of the load case; ``case_path``: path of the
    load case in the file, such as ``cases[0]``.
    """
    seen: set[tuple[int, str]] = set()
    for j, other in enumerate(case.supports):
        supports = [(i, s) for i, s in enumerate(keys.supports) if abs(s.at - other.at) <= MERGE]
        if not supports:
            places = ", ".join(length_text(s.at) for s in keys.supports) or "none, as the scene has no supports"
            advice = "correct the position, or add the support to the scene"
            yield Fault((f"{case_path}.supports[{j}].at",), f"position of a support of the scene ({places})", advice)
            continue
        held = {name: i for i, s in supports for name, _ in s.fixed}
        for name in other.displace.given:
            key = f"{case_path}.supports[{j}].displace.{name}"
            if name not in held:
                allowed = f"a degree of freedom that the scene's support fixes ({', '.join(held) or 'none'})"
                yield Fault((key,), allowed, f"add {name} to fix of the scene's support", name)
            elif (held[name], name) in seen:
                allowed = "each degree of freedom once in a load case"
                yield Fault((key,), allowed, "keep one of the two values", f"{name} twice")
            else:
                seen.add((held[name], name))


def fault_with_keys_of_load_case(fault: Fault, case_number: int) -> Fault:
    """Return a fault of the scene under a load case; the keys of this load case are listed before those of the scene.

    The message names the first key that the file has, so that it names ``cases[k].KEY`` where the load case states KEY.
    ``case_number``: number k of the load case, from 0.
    """
    blamed = tuple(f"cases[{case_number}].{key}" for key in fault.keys if key.startswith(("loads", "supports")))
    oversize = () if blamed else (f"cases[{case_number}].oversize",)
    return replace(fault, keys=(*blamed, *oversize, *fault.keys))
