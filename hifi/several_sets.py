"""3D reference of several sets on one shaft: a 3D nut and grooved stretch of shaft for each set, beams between.

The bodies of a set are those of a scene of one set, in stations that begin at its stretch, so that equal sets share them.
The contacts of all sets are one problem: stretches and beams are one structure (`hifi.shaft.mounting`), a nut is fixed,
or rides on a housing that can move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np

from rollbench.hifi.coupling import PlacedSet
from rollbench.hifi.elements.rigid import transport
from rollbench.hifi.meshing.settings import closing
from rollbench.hifi.reference import ROUNDS, Case, ReferenceResult, reporting
from rollbench.hifi.setup import Setup
from rollbench.hifi.shaft.beam import Frame, ShaftSection, tube
from rollbench.hifi.shaft.mounting import Carried, Mounted, mount_all
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Errors, Scene, Support
from rollbench.meshes.solid import SHAFT

#: Overlap [m] of neighbouring rings that is rounding.
NEAR = 1e-6
#: Relative error of a preload by force that is enough, and steps that are tried: contact loads settle to a like share.
MET, STEPS = 1e-5, 12
#: Step of the differences that begin a preload by force, in logarithms; the part of their slope's largest singular value
#: below which a direction is noise: nuts that press one another carry one force.
DIFFERENCE, NOISE = 0.05, 1e-2


@dataclass(frozen=True)
class SetBodies:
    """Bodies of a set that are meshed."""

    #: Scene of the set without errors, in local stations.
    bodies: Scene
    #: Parts of the set with their errors.
    parts: Scene
    #: Station of the shaft where the local stations begin [m].
    shift: float


def bodies_of(assembly: Assembly) -> tuple[SetBodies, ...]:
    """Bodies of each set that are meshed.

    A stretch of shaft reaches half the way to the next set, or as far beyond the nut as that of a scene of one set.

    Parameters
    ----------
    assembly : Assembly
        The shaft with its sets.

    Returns
    -------
    tuple[SetBodies, ...]
        Bodies of each set, in order.

    Raises
    ------
    ValueError
        A set has no 3D body (rollers, an inner ring on a housing), nuts overlap, or the shaft is heated.
    """
    for s in assembly.sets:
        if not isinstance(s.parts, Scene):
            raise ValueError(
                f"{s.name}: a row of rollers has no 3D body on its shaft (mesh-study presses one of its rollers in 3D)"
            )
        if s.carrier is not None:
            raise ValueError(f"{s.name}: an inner ring on a housing has no 3D body")
    if assembly.thermal_strain:
        raise ValueError("a shaft that warms is not part of the 3D reference")
    sets = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    faces = [(p.nut.position - p.nut.length / 2.0, p.nut.position + p.nut.length / 2.0) for _, p in sets]
    order = sorted(range(len(sets)), key=lambda k: faces[k])
    room = [np.inf] * len(sets)
    for a, b in pairwise(order):
        gap = faces[b][0] - faces[a][1]
        if gap < -NEAR:
            names = f"{sets[a][0].name} and {sets[b][0].name}"
            raise ValueError(f"{names} overlap by {-1e3 * gap:.4g} mm: a stretch of 3D shaft carries one set")
        half = round(gap / 2.0, 10)  # equal nuts are equal in their last digit too
        room[a], room[b] = min(room[a], half), min(room[b], half)
    stations = {*(x.at for x in assembly.supports), *(x.at for x in assembly.loads)}
    reach = min((*stations, *(x for face in faces for x in face))), max((*stations, *(x for face in faces for x in face)))
    return tuple(_bodies(parts, assembly, room[k], stations, reach) for k, (_, parts) in enumerate(sets))


def _bodies(parts: Scene, assembly: Assembly, room: float, stations: set[float], reach: tuple[float, float]) -> SetBodies:
    """Bodies of a set in local stations; reach: outermost stations [m] that the shaft is needed for."""
    wanted = SHAFT * parts.track.pitch_radius if parts.solid.shaft is None else parts.solid.shaft
    half = parts.nut.length / 2.0 + min(wanted, room)
    position = min(parts.nut.position, half)
    shift = parts.nut.position - position
    high = min(position + half, assembly.screw.length - shift)
    inner = [z - shift for z in stations if 0.0 <= z - shift <= high]
    beyond = [-half] * (reach[0] < shift) + [high + half] * (reach[1] > shift + high)
    scene = replace(
        parts,
        name="",
        title="",
        source="",
        assumed=(),
        nut=replace(parts.nut, position=position),
        screw=replace(parts.screw, length=high),
        solid=replace(parts.solid, shaft=min(wanted, room)),
        supports=tuple(Support(z, ()) for z in sorted((*inner, *beyond))),
        loads=(),
        friction=None,
        motion=None,
        circulation=None,
        time=None,
    )
    return SetBodies(replace(scene, errors=Errors()), scene, shift)


def solve_sets(
    assembly: Assembly, setups: Sequence[Setup], *, frozen: bool = False, step: Callable[[str], None] = lambda _: None
) -> ReferenceResult:
    """Solve an assembly.

    Parameters
    ----------
    assembly : Assembly
        The shaft with its sets.
    setups : Sequence[Setup]
        Prepared bodies of each set (`bodies_of`), in order.
    frozen, step : , default False
        As for `solve_reference`.

    Returns
    -------
    ReferenceResult
        The solution; a preload that is not met is in its ``status``.

    Raises
    ------
    ValueError
        As `bodies_of`, and for a rigid nut on a housing that moves.
    """
    begin, frame = perf_counter(), Frame.of(assembly)
    each = zip(assembly.sets, bodies_of(assembly), setups, strict=True)
    placed = tuple(PlacedSet(up, b.parts, up.sides, b.shift, frame.number(s.housing), s.offset) for s, b, up in each)
    mounted = _mounted(assembly, placed, frame)
    placed, unmet = _preloaded(assembly, placed, frame)
    found = Case(placed, frame, mounted).end(ROUNDS, reporting(assembly.name, begin, step), frozen=frozen)
    status = f"not converged: {unmet}" if unmet and found.status == "converged" else found.status
    return replace(found, status=status, seconds=perf_counter() - begin)


def _mounted(assembly: Assembly, placed: Sequence[PlacedSet], frame: Frame) -> Mounted:
    """Mount the stretches on the shaft, from left to right, and the nuts that ride on housings."""
    carried = []
    for p in placed:
        if p.housing is None:
            continue
        if p.setup.nut is None:
            raise ValueError("a rigid nut on a housing that moves is not part of the 3D reference")
        at = frame.housings[p.housing].at - p.shift
        carried.append(Carried(p.setup.nut.G, p.setup.nut.rigid @ transport(-at), p.housing))
    stretches = [p.setup.screw.stretch.moved(p.shift) for p in placed]
    steps = [z for segment in assembly.segments for z in (segment.start, segment.end)]
    return mount_all(stretches, frame, _sections(assembly, placed), steps, carried)


def _sections(assembly: Assembly, placed: Sequence[PlacedSet]) -> Callable[[float], ShaftSection]:
    """Section of the shaft at a station: of its plain stretch there, or else of the first thread."""
    screw, threads = assembly.screw, [p.setup for p in placed if p.setup.map.rg != 0.0]
    known = [setup for setup in threads if setup.homogenised is not None or setup.dims.shaft_radius is not None]
    base = known[0].section if known else tube(screw.outer_diameter / 2.0, screw.bore / 2.0, screw.material)
    plain = [(s.start, s.end, tube(s.diameter / 2.0, s.bore / 2.0, screw.material)) for s in assembly.segments]

    def at(z: float) -> ShaftSection:
        return next((section for low, high, section in plain if low <= z <= high), base)

    return at


def _preloaded(assembly: Assembly, placed: tuple[PlacedSet, ...], frame: Frame) -> tuple[tuple[PlacedSet, ...], str]:
    """Replace preloads by force with shifts of the nuts, found without loads; and a text where a preload is not met.

    Newton's method by secants on logarithms of force and shift, in which a power law is linear.
    """
    preloaded = [k for k, s in enumerate(assembly.sets) if s.preload > 0.0]
    if not preloaded:
        return placed, ""
    idle = tuple(replace(h, force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)) for h in frame.housings)
    bare = replace(frame, loads=(), housings=idle)
    mounted = _mounted(replace(assembly, loads=()), placed, bare)
    goal = np.log([assembly.sets[k].preload for k in preloaded])

    def shifted(depth: Array) -> tuple[PlacedSet, ...]:
        out = list(placed)
        for k, x in zip(preloaded, np.exp(depth), strict=True):
            away = -1.0 if assembly.sets[k].thrust == "+z" else 1.0
            out[k] = replace(out[k], offset=out[k].offset + away * float(x))
        return tuple(out)

    def excess(depth: Array) -> Array:
        found = Case(shifted(depth), bare, mounted).end(ROUNDS)
        force = np.abs([wrench[2] for wrench in found.on_shaft])[preloaded]
        return np.asarray(np.log(np.maximum(force, 1e-300)) - goal)

    depth = np.log([closing(placed[k].scene, assembly.sets[k].preload) for k in preloaded])
    value = excess(depth)
    slope = np.column_stack([(excess(depth + DIFFERENCE * e) - value) / DIFFERENCE for e in np.eye(len(preloaded))])
    for _ in range(STEPS):
        if float(np.abs(value).max()) <= MET:
            break
        move = np.clip(np.linalg.lstsq(slope, -value, rcond=NOISE)[0], -1.0, 1.0)
        if not move.any():  # no shift of these nuts moves a force
            break
        new = excess(depth + move)
        slope = slope + np.outer(new - value - slope @ move, move) / float(move @ move)
        depth, value = depth + move, new
    worst = float(np.abs(value).max())
    return shifted(depth), "" if worst <= MET else f"preloads by force are not met, off by {100.0 * worst:.2g} %"
