"""Arrays of an assembly for the kernels: balls and rollers of all sets between the rows of a `Structure`.

Between elastic bodies a roller is one element: a ring moves as a rigid body, so that a slice's approach is that of the
roller's middle plus its position times the slope along the roller: two motions at each ring determine all slices, and the
slices' law is that of the model lin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_force
from rollbench.lowfi.rollers import slice_middles, tapered_bearing
from rollbench.lowfi.statics.axis.structure import Structure, structure_of
from rollbench.lowfi.statics.contacts import hertz_C
from rollbench.lowfi.statics.kernel.beam import element_constants
from rollbench.lowfi.statics.kernel_types import AxisArrays, AxisBalls, AxisRollers, RollerContacts, RowState
from rollbench.lowfi.statics.problem import Problem, flank_rows, largest_interference, pack_geometry, round_off_approach
from rollbench.lowfi.statics.settle import Scale, SetFlanks
from rollbench.lowfi.statics.shape import motion_matrices
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import SIDES, Load, Scene
from rollbench.meshes.section import BeamSection, contact_stations

Ints = NDArray[np.int64]
#: Balls of a set: where they are, and their specimen of random errors.
Placed = tuple[BallLayout, Specimen]

#: Sides that a set uses by the thrust on the shaft that it carries: SL-NR closes under thrust along +z.
USE = {
    "both": np.array([True, True, True, True]),
    "+z": np.array([True, False, False, True]),
    "-z": np.array([False, True, True, False]),
    "deep groove": np.array([True, False, False, True]),
}


@dataclass
class BallSet:
    """Balls of one set among all, with N balls."""

    #: The set.
    of: RollingSet
    #: Problem of the set, with the nodes of the whole shaft.
    problem: Problem
    #: Indices of its balls among those of all sets.
    balls: slice
    #: Row of its housing, -1 for a fixed one.
    outer: int
    #: First row that moves each flank ``(N, 4)``, as in `AxisBalls`.
    row: Ints
    #: Motion of the flanks by those rows ``(N, 4, 2, m)``.
    B: Array
    #: Prescribed motion of the flanks ``(N, 4, 2)`` [m].
    v0: Array

    def moved(self, motions: Array) -> Array:
        """Return the motions ``(N, 4, 2, ...)`` of the flanks by those of all rows ``(r, 6, ...)``."""
        flat = motions.reshape(-1, *motions.shape[2:])
        found = np.einsum("nsak,nsk...->nsa...", self.B, flat[6 * self.row[..., None] + np.arange(self.B.shape[3])])
        found[self.row < 0] = 0.0
        return np.asarray(found)

    def of_one_row(self, flanks: slice) -> Array:
        """Return B ``(N, 2, 2, 6)`` of two flanks that one row moves."""
        B = self.B[:, flanks]
        return np.asarray(B.reshape(*B.shape[:3], -1, 6).sum(axis=3))


@dataclass(frozen=True)
class RollerSet:
    """Slices of one row of rollers among all."""

    #: The set.
    of: RollingSet
    #: The row of rollers.
    row: RollerRow
    #: Indices of its slices among those of all rows.
    slices: slice
    #: Azimuths of its rollers ``(count,)`` [rad].
    azimuths: Array
    #: Slices of the rollers as the kernels take them.
    arrays: AxisRollers


@dataclass
class System:
    """Assembly ready for the kernels."""

    #: The assembly.
    assembly: Assembly
    #: Shaft, housings and springs.
    structure: Structure
    #: Sets of balls.
    balls: list[BallSet]
    #: Rows of rollers.
    rollers: list[RollerSet]
    #: Largest pitch radius [m], which makes forces of moments.
    arm: float
    #: Structure as the kernels take it.
    axis: AxisArrays = field(repr=False)
    #: All balls.
    contacts: AxisBalls = field(repr=False)
    #: All slices.
    slices: AxisRollers = field(repr=False)


def placed(assembly: Assembly, member: int = 0) -> list[Placed]:
    """Return the positions of the balls of each set, and its specimen of random errors."""
    scenes = [s.parts for s in assembly.sets if isinstance(s.parts, Scene)]
    layouts = [ball_layout(scene) for scene in scenes]
    return [(x, specimen(scene, x, member)) for scene, x in zip(scenes, layouts, strict=True)]


def build(
    assembly: Assembly,
    member: int = 0,
    uses: Sequence[NDArray[np.bool_]] | None = None,
    places: Sequence[Placed] | None = None,
    section: BeamSection | None = None,
) -> System:
    """Return the arrays of an assembly.

    Parameters
    ----------
    assembly
        The assembly.
    member
        Number of the specimen, for random errors.
    uses
        Flanks of each set of balls that are built ``(4,)``; None: all that its direction of thrust allows.
    places
        What `placed` returns, where that is known.
    section
        Section of the threaded shaft, in place of the scene's.

    Raises
    ------
    ValueError
        Dimensions that leave no shaft, or a freedom that is fixed twice.
    """
    parts = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    rows = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, RollerRow)]
    built = [USE[s.thrust] for s, _ in parts] if uses is None else list(uses)
    placements = placed(assembly, member) if places is None else places
    stations = [
        contact_stations(scene, x)[:, u[:2]]
        for (s, scene), (x, _), u in zip(parts, placements, built, strict=True)
        if s.carrier is None
    ]
    rings = np.array([s.position for s, _ in rows])
    structure = structure_of(assembly, np.concatenate([rings, *(x.ravel() for x in stations)]), section)
    balls: list[BallSet] = []
    first = 0
    for (rolling, scene), use, place in zip(parts, built, placements, strict=True):
        balls.append(_ball_set(rolling, scene, structure, use, place, first))
        first = balls[-1].balls.stop
    rollers: list[RollerSet] = []
    first = 0
    for rolling, row in rows:
        rollers.append(_roller_set(rolling, row, structure, first))
        first = rollers[-1].slices.stop
    arm = max(
        [b.problem.scene.track.pitch_radius for b in balls] + [tapered_bearing(r.row).pitch_diameter / 2.0 for r in rollers]
    )
    contacts, slices = _all_balls(balls), _all_rollers(rollers)
    return System(assembly, structure, balls, rollers, arm, _axis(structure, contacts, slices), contacts, slices)


def _ball_set(
    rolling: RollingSet,
    scene: Scene,
    structure: Structure,
    use: NDArray[np.bool_],
    place: Placed,
    first: int,
    arms: Array | None = None,
) -> BallSet:
    layout, drawn = place
    parts = (scene, drawn, layout, arms)
    geometry, closure = pack_geometry(scene, drawn, hertz_C(scene, drawn), use)
    n, nodes, N = structure.nodes.size, structure.nodes, layout.z.size
    stations = contact_stations(scene, layout)
    nodal, built = scene.ingredients.partition == "nodal", int(np.argmax(use[:2]))
    if rolling.carrier is not None:
        node = np.full((N, 2), structure.row[rolling.carrier])
    elif nodal:
        node = np.abs(nodes[None, None, :] - stations[:, :, None]).argmin(axis=2)
        node[:, ~use[:2]] = node[:, [built]]
    outer = -1 if rolling.housing is None else structure.row[rolling.housing]
    at = float(structure.at[outer - n]) if outer >= 0 else scene.nut.position
    on_nut = np.stack([flank_rows(parts, s, np.full(N, at)) for s in (2, 3)], axis=1)
    v0 = np.zeros((N, 4, 2))
    v0[:, 2:] = rolling.offset * on_nut[..., 2]
    if nodal or rolling.carrier is not None:
        on_screw = np.stack([flank_rows(parts, s, structure.stations[node[:, s]]) for s in range(2)], axis=1)
    else:
        sides = [s if use[s] else built for s in range(2)]
        around = [motions_of(structure, stations[:, s]) for s in range(2)]
        node = np.stack([around[s][0] for s in sides], axis=1)
        on_screw = np.stack([flank_rows(parts, s, stations[:, s]) @ around[s][1] for s in sides], axis=1)
    width, r = (6 if nodal else 12), structure.stations.size
    pieces = widened(node, on_screw, width, r), widened(np.full((N, 2), outer), on_nut, width, r)
    row, B = (np.concatenate(x, axis=1) for x in zip(*pieces, strict=True))
    problem = Problem(
        scene=scene,
        layout=layout,
        drawn=drawn,
        nodes=nodes,
        section=structure.sections[0],
        fixed=structure.fixed[:n],
        prescribed=structure.prescribed[:n],
        load=structure.load[:n],
        node=node,
        B=B[:, :2],
        geometry=geometry,
        closure=closure,
        use=use,
        left_out_elements=0,
    )
    return BallSet(rolling, problem, slice(first, first + N), outer, row, B, v0)


def motions_of(structure: Structure, stations: Array) -> tuple[Ints, Array]:
    """Return first nodes ``(k,)`` around stations ``(k,)`` [m], and motions there by both nodes ``(k, 6, 12)``."""
    nodes = structure.nodes
    element = np.clip(np.searchsorted(nodes, stations, side="right") - 1, 0, nodes.size - 2)
    sections = [structure.sections[e] for e in element]
    EA, EI, GJ, kGA = np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in sections]).T
    return motion_matrices(stations, nodes, BeamSection(EA, EI, GJ, kGA))


def widened(row: Ints, B: Array, width: int, rows: int) -> tuple[Ints, Array]:
    """Return rows and coefficients ``(..., width)`` of two neighbouring rows for motions of one row, B ``(..., 6)``.

    The last of all ``rows`` is taken as the second of two.
    """
    if B.shape[-1] == width:
        return row, B
    last = row == rows - 1
    first, second = (np.concatenate(x, axis=-1) for x in ((B, np.zeros_like(B)), (np.zeros_like(B), B)))
    return row - last, np.where(last[..., None, None], second, first)


def with_arms(system: System, arms: Sequence[Array]) -> System:
    """Return the system with its Hertz constants and lever arms of all ball sets longer by ``(N, 4, 2)`` [m]."""
    balls = []
    for b, m in zip(system.balls, arms, strict=True):
        p = b.problem
        longer = _ball_set(b.of, p.scene, system.structure, p.use, (p.layout, p.drawn), b.balls.start, m)
        longer.problem.C[:] = p.C
        balls.append(longer)
    return replace(system, balls=balls, contacts=_all_balls(balls)._replace(tiny=system.contacts.tiny))


def set_flanks(system: System, state: RowState, shifts: Array | None = None) -> list[SetFlanks]:
    """Return the contacts, centres and flank motions of each set of balls.

    shifts ``(N, 4, 2)`` [m]: of all flanks, where they are not those of the rows.
    """
    moved = [moved_flanks(b, state.q) if shifts is None else shifts[b.balls] for b in system.balls]
    contact, centre = state.contact, state.p
    return [SetFlanks(b.problem, contact[b.balls], centre[b.balls], m) for b, m in zip(system.balls, moved, strict=True)]


def moved_flanks(b: BallSet, q: Array) -> Array:
    """Return the motions ``(N, 4, 2)`` [m] of a set's flanks by those of the rows ``(r, 6)``."""
    return np.asarray(b.v0 + b.moved(q))


def _all_balls(sets: list[BallSet]) -> AxisBalls:
    """Return the balls of all sets one after the other; the sets' problems then hold views of them.

    Profiles are padded with zeros.
    """
    degree = max((b.problem.drawn.profile.shape[1] for b in sets), default=0)
    row, profile = [], []
    for b in sets:
        N = b.problem.layout.z.size
        row.append(b.row)
        terms = np.zeros((4, degree))
        terms[:, : b.problem.drawn.profile.shape[1]] = b.problem.drawn.profile
        profile.append(np.broadcast_to(terms, (N, 4, degree)))

    def joined(arrays: Sequence[NDArray[Any]], shape: tuple[int, ...]) -> NDArray[Any]:
        return np.ascontiguousarray(np.concatenate([np.zeros((0, *shape)), *arrays]))

    geometry = joined([b.problem.geometry for b in sets], (4, 9))
    for b in sets:  # constants that change in one place change in the other
        b.problem = replace(b.problem, geometry=geometry[b.balls])
    return AxisBalls(
        row=joined(row, (4,)).astype(np.int64),
        B=joined([b.B for b in sets], (4, 2, sets[0].B.shape[3] if sets else 6)),
        v0=joined([b.v0 for b in sets], (4, 2)),
        geometry=geometry,
        closure=joined([b.problem.closure for b in sets], (2,)),
        r_ball=joined([b.problem.drawn.ball_radius for b in sets], ()),
        profile=joined(profile, (4, degree)),
        tiny=0.0,
    )


def _roller_set(rolling: RollingSet, row: RollerRow, structure: Structure, first: int) -> RollerSet:
    """Return the slices of a row on the generators of the cup, along whose normal cone and cup approach.

    Race and rib together give the cone the same line of action (`lowfi.rollers`).
    """
    n, bearing = structure.nodes.size, tapered_bearing(row)
    inner = int(np.abs(structure.nodes - rolling.position).argmin())
    outer = -1 if rolling.housing is None else structure.row[rolling.housing]
    sign = 1.0 if rolling.thrust == "+z" else -1.0
    sin, cos = np.sin(row.cup_angle), np.cos(row.cup_angle)
    place = slice_middles(row.length, row.slices)
    azimuths = row.phase + 2.0 * np.pi * np.arange(row.count) / row.count
    c, s, one_each = np.cos(azimuths), np.sin(azimuths), np.ones(row.count)
    normal = np.stack([cos * c, cos * s, sign * sin * one_each], axis=1)[:, None, :]
    along = np.stack([sin * c, sin * s, -sign * cos * one_each], axis=1)[:, None, :]
    mean = bearing.apex_distance * sin * np.stack([c, s, 0.0 * c], axis=1)[:, None, :]
    point = mean + place[None, :, None] * along + np.array([0.0, 0.0, rolling.position])
    normal = np.broadcast_to(normal, point.shape)
    stations = (float(structure.nodes[inner]), float(structure.at[outer - n]) if outer >= 0 else rolling.position)
    B = np.empty((row.count, row.slices, 2, 6))
    for end, (at, direction) in enumerate(zip(stations, (1.0, -1.0), strict=True)):
        arm = point - np.array([0.0, 0.0, at])
        B[:, :, end, :3], B[:, :, end, 3:] = direction * normal, direction * np.cross(arm, normal)
    law, count = bearing.law(), row.count * row.slices
    arrays = AxisRollers(
        np.tile([inner, outer], (count, 1)).astype(np.int64),
        B.reshape(count, 2, 6),
        np.tile(place**2 / row.crown, row.count) + sign * sin * rolling.offset,
        np.full(count, row.length / row.slices),
        np.full(count, float(law.g)),
        np.full(count, float(law.s)),
    )
    return RollerSet(rolling, row, slice(first, first + count), azimuths, arrays)


def _all_rollers(sets: list[RollerSet]) -> AxisRollers:
    """Return the slices of all rows one after the other."""
    if not sets:
        none = np.zeros(0)
        return AxisRollers(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2, 6)), none, none, none, none)
    return AxisRollers(*(np.ascontiguousarray(np.concatenate(x)) for x in zip(*(r.arrays for r in sets), strict=True)))


def _axis(structure: Structure, contacts: AxisBalls, slices: AxisRollers) -> AxisArrays:
    """Return the arrays of shaft, housings and springs, with the matrix envelope.

    Each housing comes right after the last node with which it has common contacts.
    """
    n, r = structure.nodes.size, structure.stations.size
    pairs = np.array([(a, b) for a in range(4) for b in range(a)])
    used = contacts.geometry[..., 5] > 0.0
    joined = [contacts.row[:, p][(used[:, p].all(axis=1)) & (contacts.row[:, p] >= 0).all(axis=1)] for p in pairs]
    if contacts.B.shape[3] > 6:
        joined = [x + np.array(step) for x in joined for step in np.ndindex(2, 2)]
    met = np.concatenate([*joined, slices.row[(slices.row >= 0).all(axis=1)]])
    springs = structure.ends[(structure.ends >= 0).all(axis=1)]
    last = np.arange(r, dtype=float)
    last[n:] = 0.0
    for i in range(n, r):
        mine = met[(met == i).any(axis=1)]
        last[i] = float(mine[mine < n].max(initial=0)) + 0.5
    order = np.argsort(last, kind="stable")
    place = np.empty(r, dtype=np.int64)
    place[order] = np.arange(r)
    links = np.concatenate([met, springs, np.column_stack([np.arange(n - 1), np.arange(1, n)])]).astype(np.int64)
    low, high = place[links].min(axis=1), place[links].max(axis=1)
    block = np.arange(r)
    np.minimum.at(block, high, low)
    first = np.repeat(6 * block, 6).astype(np.int64)
    size = np.arange(6 * r) - first + 1
    start = np.concatenate([np.cumsum(size) - size - first, [size.sum()]]).astype(np.int64)
    sections = np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in structure.sections])
    lengths = np.diff(structure.nodes)
    return AxisArrays(
        lengths=lengths,
        sections=sections,
        constants=np.array([element_constants(*x) for x in zip(lengths, sections, strict=True)]),
        fixed=structure.fixed,
        load=structure.load,
        ends=structure.ends,
        reach=structure.reach,
        springs=structure.springs,
        place=place,
        first=first,
        start=start,
    )


def applied(system: System) -> float:
    """Return sum of the loads on shaft and housings [N], moments over the largest pitch radius, without thermal loads."""
    bodies: tuple[Load | Housing, ...] = (*system.assembly.loads, *system.assembly.housings)
    return float(sum(np.abs(x.force).sum() + np.abs(x.moment).sum() / system.arm for x in bodies))


def pair_compliance(b: BallSet) -> float:
    """Return C of two opposite contacts in series [m/N^(2/3)]."""
    return float(np.mean(b.problem.C[:, 0] + b.problem.C[:, 3]))


def squeeze(b: BallSet) -> float:
    """Return the approach [m] of a set's contacts by oversized balls or the shift of its outer part, all else fixed."""
    shift = {"+z": -b.of.offset, "-z": b.of.offset}.get(b.of.thrust, abs(b.of.offset))
    return max(largest_interference(b.problem), shift * float(np.sin(b.problem.scene.track.contact_angle)))


def mean_share(system: System) -> float:
    """Return the mean share of all loads of a rolling element [N]."""
    return applied(system) / max(1, system.contacts.r_ball.size + sum(r.row.count for r in system.rollers))


def typical_force(system: System, b: BallSet) -> float:
    """Return the force of a typical contact of a set, at least 1e-6 N.

    Its mean share of the loads, or its preload; that of an approach of a micrometre where only displacements are given.
    """
    pair = pair_compliance(b)
    force = max(mean_share(system), float(contact_force(squeeze(b), pair)))
    if force == 0.0 and np.any(system.structure.prescribed):
        force = float(contact_force(1e-6, pair))
    return max(force, 1e-6)


def scale_of(system: System) -> Scale:
    """Return the scales of all sets.

    A contact that counts as unloaded has the round-off of a typical force, or where nothing presses any, the force of an
    approach by round-off.
    """
    load, share = system.structure.load, mean_share(system)
    stiffness, squeezed = 1.0, 0.0
    for b in system.balls:
        pair = pair_compliance(b)
        squeezed = max(squeezed, float(contact_force(squeeze(b), pair)))
        if share == 0.0 and squeezed == 0.0 and np.any(system.structure.prescribed):
            squeezed = float(contact_force(1e-6, pair))
    force = max(share, squeezed)
    for b in system.balls:
        stiffness = max(stiffness, float(np.cbrt(force) / pair_compliance(b)) if force > 0.0 else 1.0)
    for r in system.rollers:
        per_length = max(force, 1.0) / r.row.length
        law = r.arrays
        stiffness = max(stiffness, r.row.length / r.row.slices / float(law.g[0] - law.s[0] * np.log(per_length)))
    floor = max(float(np.abs(load[:, :3]).max()), float(np.abs(load[:, 3:]).max()) / system.arm, squeezed)
    none = 1e-14 * force
    if force == 0.0:
        pressed = (contact_force(round_off_approach(b.problem), pair_compliance(b)) for b in system.balls)
        none = max(map(float, pressed), default=0.0)
    return Scale(force, stiffness, floor, none)


@dataclass(frozen=True)
class RollerElements:
    """M rollers of all rows as elements between elastic bodies."""

    #: Node of the shaft ``(M,)``.
    node: NDArray[np.int64]
    #: Row of the cup's motions ``(M,)``, -1 for a fixed one.
    outer: NDArray[np.int64]
    #: Normal motion of cone and cup at the roller's middle, and its slope along the roller times the length, by those rows
    #: ``(M, 2, 2, 6)``.
    B: Array
    #: Slices of the rollers.
    contacts: RollerContacts

    @property
    def count(self) -> int:
        """Number of rollers."""
        return self.node.size


def roller_elements(sets: list[RollerSet]) -> RollerElements:
    """Return the rollers of all rows, one after the other."""
    M, K = sum(r.row.count for r in sets), max((r.row.slices for r in sets), default=0)
    node, outer = np.zeros(M, dtype=np.int64), np.full(M, -1, dtype=np.int64)
    B, law = np.zeros((M, 2, 2, 6)), np.zeros((2, M))
    place, width, drop = np.zeros((3, M, K))
    first = 0
    for r in sets:
        a, n = r.arrays, r.row.slices
        mine = slice(first, first + r.row.count)
        first = mine.stop
        x = slice_middles(r.row.length, n) / r.row.length
        rows = a.B.reshape(r.row.count, n, 2, 6) * np.array([1.0, -1.0])[:, None]  # lin takes the approach, this motions
        base = np.linalg.pinv(np.column_stack([np.ones(n), x])) if n > 1 else np.array([[1.0], [0.0]])
        B[mine] = np.einsum("ak,ikej->ieaj", base, rows)
        place[mine, :n] = x
        width[mine, :n], drop[mine, :n] = a.width.reshape(-1, n), a.drop.reshape(-1, n)
        law[0, mine], law[1, mine] = a.g[0], a.s[0]
        node[mine], outer[mine] = a.row[0]
    return RollerElements(node, outer, B, RollerContacts(place, width, drop, *law))


def roller_springs(count: int, stiffness: float) -> Array:
    """Return linear springs between cone and cup at the rollers' middles in place of slices ``(count, 2, 8)``.

    As `lowfi.statics.response.spring_rows`.
    """
    rows = np.zeros((count, 2, 8))
    rows[:, 0, 0], rows[:, 0, 4] = np.sqrt(stiffness), -np.sqrt(stiffness)
    return rows


def asked(assembly: Assembly) -> float | str:
    """Return the station [m] or housing whose motion and stiffness are reported.

    That of the assembly, else the first loaded housing, the first load, the first set.

    Parameters
    ----------
    assembly
        Shaft with several sets.
    """
    if assembly.stiffness_at is not None:
        return assembly.stiffness_at
    loaded = [h.name for h in assembly.housings if any(h.force) or any(h.moment)]
    if loaded:
        return loaded[0]
    return assembly.loads[0].at if assembly.loads else assembly.sets[0].position


def asked_row(system: System) -> int:
    """Return the row of motions whose stiffness is reported; -1 for a fixed housing."""
    at, s = asked(system.assembly), system.structure
    return s.row[at] if isinstance(at, str) else int(np.abs(s.nodes - at).argmin())


def left_out(system: System) -> tuple[str, ...]:
    """Return sentences on flanks that were left out although their sets could use them."""
    notes = []
    for b in system.balls:
        idle = [SIDES[k] for k in np.flatnonzero(USE[b.of.thrust] & ~b.problem.use)]
        if idle:
            notes.append(f"{b.of.name}: sides {' and '.join(idle)}: load or offset opens them, and every ball clears them")
    return tuple(notes)
