"""3D reference of several nuts or bearings on one shaft, each meshed in 3D with the part of the shaft around it.

The bodies of a nut or bearing are those that it has as the only one on its shaft. Their axial positions count from the
start of its part of the shaft, so that equal nuts share their meshes. The contacts of all of them are one problem: the
parts of the shaft that are meshed in 3D and the beams between them form one structure (`hifi.shaft.mounting`), and each nut
is fixed or carried by a housing that can move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np

from rollbench.hifi.coupling import PlacedNut
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.meshing.settings import nut_shift_for_axial_force
from rollbench.hifi.reference import ROUNDS, LoadCase, ReferenceResult, make_slow_round_reporter
from rollbench.hifi.setup import CondensedGeometry, Step
from rollbench.hifi.shaft.beam import ShaftSection, ShaftSupports, tube_section
from rollbench.hifi.shaft.mounting import NutOnHousing, SupportedShaft, join_and_support_shaft_parts
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Errors, Scene, Support
from rollbench.meshes.solid import SHAFT

#: Largest overlap [m] of neighbouring nuts or bearings that counts as rounding error.
NEAR = 1e-6
#: Accepted relative error of a preload by force, similar to that of the contact loads; largest number of Newton's steps
#: that find the shifts of the nuts.
MET, STEPS = 1e-5, 12
#: Step of the logarithm of a nut's shift in the difference quotients that give the first derivatives of the preloads by the
#: shifts. Singular value of the matrix of derivatives, over the largest one, below which it counts as zero: nuts that press
#: against one another carry the same force, so that the matrix is singular.
DIFFERENCE, NOISE = 0.05, 1e-2


@dataclass(frozen=True)
class MeshedSetGeometry:
    """Geometry that is meshed in 3D for one of several nuts or bearings on a shaft, with the shaft around it."""

    #: Shaft part, balls, and nut or bearing rings without manufacturing errors, at axial positions from
    #: ``origin_on_shaft``.
    parts_without_errors: Scene
    #: The same parts with their manufacturing errors.
    parts_with_errors: Scene
    #: Axial position on the shaft from which the axial positions of the two scenes are counted [m].
    origin_on_shaft: float


def meshed_geometry_of_each_set(assembly: Assembly) -> tuple[MeshedSetGeometry, ...]:
    """Return the geometry that is meshed in 3D for each nut or bearing on a shaft.

    The geometry includes the part of the shaft around the nut. This part ends half-way to the next nut or bearing, or
    earlier where it would end if the nut or bearing were the only one on its shaft.

    Parameters
    ----------
    assembly : Assembly
        The shaft with its nuts and bearings.

    Returns
    -------
    tuple[MeshedSetGeometry, ...]
        Bodies of each nut or bearing, in order.

    Raises
    ------
    ValueError
        There are rollers or an inner ring on a housing, two nuts or bearings overlap, or the shaft is heated.
    """
    for s in assembly.sets:
        if not isinstance(s.parts, Scene):
            raise ValueError(
                f"{s.name}: the 3D reference cannot solve a roller bearing on a shaft; the command mesh-study solves a "
                "single roller in 3D"
            )
        if s.carrier is not None:
            raise ValueError(f"{s.name}: the 3D reference cannot model a bearing whose inner ring is on a housing")
    if assembly.thermal_strain:
        raise ValueError(
            "the 3D reference does not model thermal expansion of the shaft: remove the shaft's temperature rise"
        )
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    faces = [(p.nut.position - p.nut.length / 2.0, p.nut.position + p.nut.length / 2.0) for _, p in sets]
    order = sorted(range(len(sets)), key=lambda k: faces[k])
    room = [np.inf] * len(sets)
    for a, b in pairwise(order):
        gap = faces[b][0] - faces[a][1]
        if gap < -NEAR:
            names = f"{sets[a][0].name} and {sets[b][0].name}"
            raise ValueError(
                f"{names} overlap by {-1e3 * gap:.4g} mm: move them apart, because each is meshed with a part of the shaft"
            )
        half = round(gap / 2.0, 10)  # equal nuts are equal in their last digit too
        room[a], room[b] = min(room[a], half), min(room[b], half)
    stations = {*(x.at for x in assembly.supports), *(x.at for x in assembly.loads)}
    positions = [*stations, *(x for face in faces for x in face)]
    span = min(positions), max(positions)
    each = zip(sets, room, strict=True)
    return tuple(_meshed_geometry_of_one_set(parts, assembly, free, stations, span) for (_, parts), free in each)


def _meshed_geometry_of_one_set(
    parts: Scene, assembly: Assembly, free_shaft_length: float, stations: set[float], shaft_span: tuple[float, float]
) -> MeshedSetGeometry:
    """Return the geometry that is meshed in 3D for one of the nuts or bearings on a shaft.

    ``parts``: parts of the nut or bearing; ``free_shaft_length``: length of shaft that is available beyond each of its
    faces [m]; ``stations``: axial positions of all supports and loads [m]; ``shaft_span``: lowest and highest axial
    position of the nuts, bearings, supports and loads on the shaft [m].
    """
    wanted = SHAFT * parts.track.pitch_radius if parts.solid.shaft is None else parts.solid.shaft
    shaft = min(wanted, free_shaft_length)
    half = parts.nut.length / 2.0 + shaft
    position = min(parts.nut.position, half)
    shift = parts.nut.position - position
    high = min(position + half, assembly.screw.length - shift)
    inner = [z - shift for z in stations if 0.0 <= z - shift <= high]
    beyond = [-half] * (shaft_span[0] < shift) + [high + half] * (shaft_span[1] > shift + high)
    scene = replace(
        parts,
        name="",
        title="",
        source="",
        assumed=(),
        nut=replace(parts.nut, position=position),
        screw=replace(parts.screw, length=high),
        solid=replace(parts.solid, shaft=shaft),
        supports=tuple(Support(z, ()) for z in sorted((*inner, *beyond))),
        loads=(),
        friction=None,
        motion=None,
        circulation=None,
        time=None,
    )
    return MeshedSetGeometry(replace(scene, errors=Errors()), scene, shift)


def solve_nuts_on_one_shaft(
    assembly: Assembly, setups: Sequence[CondensedGeometry], *, frozen: bool = False, step: Step = lambda _: None
) -> ReferenceResult:
    """Solve the contacts of several nuts or bearings on one shaft.

    Parameters
    ----------
    assembly : Assembly
        The shaft with its nuts and bearings.
    setups : Sequence[CondensedGeometry]
        Meshed and condensed geometry of each nut or bearing (`meshed_geometry_of_each_set`), in order.
    frozen : bool, default False
        Whether to compute, in addition, the contact loads with nominal contact normals and gaps.
    step : Step, optional
        Function that is called with a progress text in every round of a solution that takes long.

    Returns
    -------
    ReferenceResult
        The solution; its ``status`` tells whether it converged and all preloads by force are reached.

    Raises
    ------
    ValueError
        There are rollers or an inner ring on a housing, two nuts or bearings overlap, the shaft is heated, or a rigid nut
        is on a housing that moves.
    """
    begin, frame = perf_counter(), ShaftSupports.from_scene(assembly)
    each = zip(assembly.sets, meshed_geometry_of_each_set(assembly), setups, strict=True)
    placed = tuple(
        PlacedNut(up, b.parts_with_errors, up.loaded_flanks, b.origin_on_shaft, frame.housing_index(s.housing), s.offset)
        for s, b, up in each
    )
    mounted = _compliance_of_supported_shaft(assembly, placed, frame)
    placed, unmet = _find_shifts_for_preloads(assembly, placed, frame)
    report = make_slow_round_reporter(assembly.name, begin, step)
    found = LoadCase(placed, frame, mounted).solve(ROUNDS, report, frozen=frozen)
    status = f"not converged: {unmet}" if unmet and found.status == "converged" else found.status
    return replace(found, status=status, solve_seconds=perf_counter() - begin)


def _compliance_of_supported_shaft(assembly: Assembly, placed: Sequence[PlacedNut], frame: ShaftSupports) -> SupportedShaft:
    """Compute the compliance of the shaft at the contacts of its nuts and bearings, under its supports and loads.

    The 3D parts of the shaft are joined by beams; nuts on movable housings are included. ``placed``: the nuts and bearings
    at their positions; ``frame``: supports, loads and housings. Raises ValueError if a rigid nut is on a movable housing.
    """
    carried = []
    for p in placed:
        if p.housing_index is None:
            continue
        nut = p.geometry.condensed_nut
        if nut is None:
            raise ValueError(
                "the 3D reference cannot model a rigid nut on a movable housing: make the nut elastic, or fix the housing"
            )
        at = frame.housings[p.housing_index].at - p.origin_on_shaft
        by_housing = nut.modes_by_rigid_motions @ rigid_motion_transfer_along_z(-at)
        carried.append(NutOnHousing(nut.G, by_housing, p.housing_index))
    stretches = [p.geometry.condensed_screw.stretch.shift_along_shaft(p.origin_on_shaft) for p in placed]
    steps = [z for segment in assembly.segments for z in (segment.start, segment.end)]
    return join_and_support_shaft_parts(stretches, frame, _shaft_section_by_position(assembly, placed), steps, carried)


def _shaft_section_by_position(assembly: Assembly, placed: Sequence[PlacedNut]) -> Callable[[float], ShaftSection]:
    """Return a function that gives the shaft's cross-section (its beam stiffnesses) at an axial position [m].

    On a smooth segment of the shaft it is the section of this segment, elsewhere that of the first threaded part.
    """
    screw, threads = assembly.screw, [p.geometry for p in placed if p.geometry.groove_map.rg != 0.0]
    known = [x for x in threads if x.equivalent_beam is not None or x.solid_dimensions.shaft_radius is not None]
    base = known[0].shaft_section if known else tube_section(screw.outer_diameter / 2.0, screw.bore / 2.0, screw.material)
    plain = [(s.start, s.end, tube_section(s.diameter / 2.0, s.bore / 2.0, screw.material)) for s in assembly.segments]
    return lambda z: next((section for low, high, section in plain if low <= z <= high), base)


def _find_shifts_for_preloads(
    assembly: Assembly, placed: tuple[PlacedNut, ...], frame: ShaftSupports
) -> tuple[tuple[PlacedNut, ...], str]:
    """Find the axial shifts of the nuts in their housings that produce the prescribed preload forces without other loads.

    The shifts are found by a secant (quasi-Newton) method on the logarithms of force and shift, in which a power law is
    linear. Returns the nuts or bearings with these shifts, and a text that says by how much a preload is missed; the text
    is empty if all preloads are reached.
    """
    preloaded = [k for k, s in enumerate(assembly.sets) if s.preload > 0.0]
    if not preloaded:
        return placed, ""
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in frame.housings)
    bare = replace(frame, loads=(), housings=idle)
    mounted = _compliance_of_supported_shaft(replace(assembly, loads=()), placed, bare)
    goal = np.log([assembly.sets[k].preload for k in preloaded])

    def with_shifted_nuts(depth: Array) -> tuple[PlacedNut, ...]:
        """Return the nuts or bearings with the preloaded nuts shifted by exp(depth) [m] against their thrust direction."""
        out = list(placed)
        for k, x in zip(preloaded, np.exp(depth), strict=True):
            away = -1.0 if assembly.sets[k].thrust == "+z" else 1.0
            out[k] = replace(out[k], nut_offset=out[k].nut_offset + away * float(x))
        return tuple(out)

    def logarithm_of_force_ratio(depth: Array) -> Array:
        """Return, for shifts exp(depth) [m], the logarithm of each preloaded nut's axial force over its preload."""
        found = LoadCase(with_shifted_nuts(depth), bare, mounted).solve(ROUNDS)
        force = np.abs([wrench[2] for wrench in found.forces_on_shaft])[preloaded]
        return np.asarray(np.log(np.maximum(force, 1e-300)) - goal)

    depth = np.log([nut_shift_for_axial_force(placed[k].scene_with_errors, assembly.sets[k].preload) for k in preloaded])
    value, steps = logarithm_of_force_ratio(depth), DIFFERENCE * np.eye(len(preloaded))
    slope = np.column_stack([(logarithm_of_force_ratio(depth + step) - value) / DIFFERENCE for step in steps])
    for _ in range(STEPS):
        if float(np.abs(value).max()) <= MET:
            break
        move = np.clip(np.linalg.lstsq(slope, -value, rcond=NOISE)[0], -1.0, 1.0)
        if not move.any():  # no shift of these nuts moves a force
            break
        new = logarithm_of_force_ratio(depth + move)
        slope = slope + np.outer(new - value - slope @ move, move) / float(move @ move)
        depth, value = depth + move, new
    worst = float(np.abs(value).max())
    return with_shifted_nuts(depth), "" if worst <= MET else f"preloads by force are not met, off by {100.0 * worst:.2g} %"
