"""Arrays for the numerical kernels of a shaft with several bearings and ball nuts: balls, rollers, beam and springs.

A *set* is one bearing row or one ball nut. A *motion row* holds the six motions (three translations, three rotations) of
one shaft node or one moving housing; `Structure` numbers these rows.

Where other bodies are elastic, a roller is one element between two rigid rings. The approach of each slice of the roller is
then the approach at the roller's middle plus the slice's position times the slope along the roller. Two motions at each
ring therefore determine all slices. The slices follow the same force law as in the model lin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_force
from rollbench.lowfi.rollers import slice_middles, tapered_bearing_of_row
from rollbench.lowfi.statics import problem as statics_problem
from rollbench.lowfi.statics.axis.structure import Structure, build_structure
from rollbench.lowfi.statics.kernel.beam import element_constants
from rollbench.lowfi.statics.kernel_types import AxisArrays, AxisBalls, AxisRollers, MotionState, RollerContacts
from rollbench.lowfi.statics.settle import ContactState, ResidualScale
from rollbench.lowfi.statics.shape import beam_interpolation_matrices
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import SIDES, Load, Scene
from rollbench.meshes.section import BeamSection, contact_force_positions

Ints = NDArray[np.int64]
#: Positions of the balls of one bearing row or ball nut, and its dimensions with random manufacturing errors.
Placed = tuple[BallLayout, GeometryWithErrors]

#: Which of the four flanks (screw left, screw right, nut left, nut right) can be loaded, by the direction of the thrust on
#: the shaft that a bearing row or ball nut carries. The diagonal pair SL-NR closes under thrust along +z.
USE = {
    "both": np.array([True, True, True, True]),
    "+z": np.array([True, False, False, True]),
    "-z": np.array([False, True, True, False]),
    "deep groove": np.array([True, False, False, True]),
}


@dataclass
class BallSet:
    """The N balls of one bearing row or ball nut of an assembly, with the motions of their four flanks.

    The bodies whose motions move the flanks are the shaft nodes and the moving housings, numbered as in `Structure`.
    """

    #: The bearing row or ball nut.
    of: RollingSet
    #: Contact problem of the balls of this row or nut, with the beam nodes of the whole shaft.
    problem: statics_problem.Problem
    #: Indices of the balls of this row or nut among the balls of the whole assembly.
    ball_indices: slice
    #: Number of the housing of the nut or outer ring among the bodies (shaft nodes, then moving housings); -1 if it is
    #: fixed.
    outer_body_row: int
    #: Number of the first body (shaft node or moving housing) that moves each flank ``(N, 4)``; -1 if the flank is fixed.
    first_body_rows: Ints
    #: Motions of the flanks, radial and along the helix's binormal, per unit of the six motions of the body in
    #: ``first_body_rows`` (m = 6), or of this body and the next one (m = 12): ``(N, 4, 2, m)``.
    B: Array
    #: Prescribed motion of the flanks ``(N, 4, 2)`` [m], by the axial offset of the nut or outer ring.
    v0: Array

    def flank_motions(self, motions: Array) -> Array:
        """Return the motions of the four flanks of N balls that follow from the motions of all bodies.

        ``motions`` ``(r, 6, ...)``: three displacements and three rotations of the r bodies, which are the shaft's nodes
        and the moving housings; further axes are load cases. Returns ``(N, 4, 2, ...)``: for each ball the four flanks
        (screw left, screw right, nut left, nut right), and two components in the ball's section plane, radial and along the
        helix's binormal. Flanks of a fixed housing do not move; prescribed offsets are not included.
        """
        flat = motions.reshape(-1, *motions.shape[2:])
        moved = flat[6 * self.first_body_rows[..., None] + np.arange(self.B.shape[3])]
        found = np.einsum("nsak,nsk...->nsa...", self.B, moved)
        found[self.first_body_rows < 0] = 0.0
        return np.asarray(found)

    def flank_motions_per_body_motion(self, flanks: slice) -> Array:
        """Return the coefficients ``(N, 2, 2, 6)`` that give the motions of two flanks by the motions of their rigid body.

        ``flanks``: the two flanks on this body, ``slice(2)`` on the inner and ``slice(2, 4)`` on the outer part. The axes
        of the result are ball, flank, component in the ball's section plane, and motion of the body.
        """
        B = self.B[:, flanks]
        return np.asarray(B.reshape(*B.shape[:3], -1, 6).sum(axis=3))


@dataclass(frozen=True)
class RollerSet:
    """Rollers of one tapered roller bearing of an assembly, divided into slices across their axes."""

    #: The bearing with its position, its housing and the direction of thrust that it carries.
    of: RollingSet
    #: Dimensions of the rollers and raceways.
    row: RollerRow
    #: Indices of the roller slices of this bearing among those of all roller bearings.
    slice_indices: slice
    #: Azimuths of the rollers ``(count,)`` [rad].
    roller_azimuths: Array
    #: Arrays of the roller slices for the kernels: motions, gaps, widths and force law.
    slice_arrays: AxisRollers


@dataclass
class AssemblyArrays:
    """Shaft with its bearings, ball nuts and housings as arrays for the numerical kernels."""

    #: Description of the assembly by the user.
    assembly: Assembly
    #: Shaft, housings and springs.
    structure: Structure
    #: Ball nuts and ball bearings.
    ball_sets: list[BallSet]
    #: Tapered roller bearings.
    roller_sets: list[RollerSet]
    #: Largest pitch radius of the bearings and nuts [m]; moments are divided by it where they are compared with forces.
    moment_arm: float
    #: Arrays of shaft, housings and springs for the kernels.
    structure_arrays: AxisArrays = field(repr=False)
    #: Arrays of all balls for the kernels.
    ball_arrays: AxisBalls = field(repr=False)
    #: Arrays of the slices of all rollers for the kernels.
    slice_arrays: AxisRollers = field(repr=False)


def ball_positions_with_errors(assembly: Assembly, member: int = 0) -> list[Placed]:
    """Return the ball positions, and the dimensions with manufacturing errors, of each ball nut and ball bearing.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    member
        Number of the specimen: each number gives other random errors.
    """
    scenes = [s.parts for s in assembly.sets if isinstance(s.parts, Scene)]
    layouts = [ball_layout(scene) for scene in scenes]
    return [(x, draw_geometry_with_errors(scene, x, member)) for scene, x in zip(scenes, layouts, strict=True)]


def build_assembly_arrays(
    assembly: Assembly,
    flanks: Sequence[NDArray[np.bool_]] | None = None,
    places: Sequence[Placed] | None = None,
    section: BeamSection | None = None,
) -> AssemblyArrays:
    """Return an assembly (shaft, bearings, ball nuts and housings) as arrays for the numerical kernels.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    flanks
        For each ball nut or ball bearing, which of its four flanks get contacts ``(4,)``. None: all flanks that can be
        loaded by thrust in the direction which the nut or bearing carries.
    places
        Result of `ball_positions_with_errors`; None: that of specimen 0.
    section
        Cross-section of the threaded shaft; None: computed from the assembly's dimensions.

    Raises
    ------
    ValueError
        If the dimensions leave no shaft, or two supports fix the same degree of freedom.
    """
    parts = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    rows = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, RollerRow)]
    used = [USE[s.thrust] for s, _ in parts] if flanks is None else flanks
    placed = ball_positions_with_errors(assembly) if places is None else places
    stations = [
        contact_force_positions(scene, layout)[:, use[:2]].ravel()
        for (s, scene), (layout, _), use in zip(parts, placed, used, strict=True)
        if s.carrier is None
    ]
    structure = build_structure(assembly, np.concatenate([[s.position for s, _ in rows], *stations]), section)
    first_balls = accumulate((layout.z.size for layout, _ in placed), initial=0)
    balls = [
        _build_ball_set(of, scene, structure, use, place, first)
        for (of, scene), use, place, first in zip(parts, used, placed, first_balls, strict=False)
    ]
    first_slices = accumulate((row.count * row.slices for _, row in rows), initial=0)
    rollers = [_build_roller_set(of, row, structure, first) for (of, row), first in zip(rows, first_slices, strict=False)]
    arm = max(
        [scene.track.pitch_radius for _, scene in parts]
        + [tapered_bearing_of_row(row).pitch_diameter / 2.0 for _, row in rows]
    )
    contacts, slices = _concatenate_balls(balls), _concatenate_rollers(rollers)
    shaft = _kernel_arrays_of_structure(structure, contacts, slices)
    return AssemblyArrays(assembly, structure, balls, rollers, arm, shaft, contacts, slices)


def _build_ball_set(
    rolling: RollingSet,
    scene: Scene,
    structure: Structure,
    used: NDArray[np.bool_],
    place: Placed,
    first_ball: int,
    arms: Array | None = None,
) -> BallSet:
    """Return the balls of one ball nut or bearing row, with the motions of their flanks by shaft nodes and housing.

    Parameters
    ----------
    rolling
        The ball nut or bearing in the assembly.
    scene
        Dimensions of the ball nut or bearing.
    structure
        Shaft, housings and springs.
    used
        Which of the four flanks (screw left, screw right, nut left, nut right) get contacts ``(4,)``.
    place
        Positions of the balls, and dimensions with their random manufacturing errors.
    first_ball
        Index of the first ball among all balls of the assembly.
    arms
        Shifts of the flanks' centres of curvature by profile errors ``(N, 4, 2)`` [m]; None: zero.
    """
    layout, drawn = place
    parts = (scene, drawn, layout, arms)
    geometry, closure = statics_problem.pack_contact_data(scene, drawn, used)
    n, nodes, N = structure.nodes.size, structure.nodes, layout.z.size
    stations = contact_force_positions(scene, layout)
    nodal, built = scene.ingredients.partition == "nodal", int(np.argmax(used[:2]))
    if rolling.carrier is not None:
        node = np.full((N, 2), structure.housing_numbers[rolling.carrier])
    elif nodal:
        node = np.abs(nodes[None, None, :] - stations[:, :, None]).argmin(axis=2)
        node[:, ~used[:2]] = node[:, [built]]
    outer = -1 if rolling.housing is None else structure.housing_numbers[rolling.housing]
    at = float(structure.housing_positions[outer - n]) if outer >= 0 else scene.nut.position
    on_nut = np.stack([statics_problem.flank_motion_matrix(parts, s, np.full(N, at)) for s in (2, 3)], axis=1)
    v0 = np.zeros((N, 4, 2))
    v0[:, 2:] = rolling.offset * on_nut[..., 2]
    if nodal or rolling.carrier is not None:
        points = structure.body_positions[node]
        on_screw = [statics_problem.flank_motion_matrix(parts, s, points[:, s]) for s in range(2)]
    else:
        sides = [s if used[s] else built for s in range(2)]
        around = [interpolate_shaft_motions(structure, stations[:, s]) for s in range(2)]
        node = np.stack([around[s][0] for s in sides], axis=1)
        on_screw = [statics_problem.flank_motion_matrix(parts, s, stations[:, s]) @ around[s][1] for s in sides]
    width, r = (6 if nodal else 12), structure.body_positions.size
    inner = pad_coefficients_to_two_bodies(node, np.stack(on_screw, axis=1), width, r)
    pieces = inner, pad_coefficients_to_two_bodies(np.full((N, 2), outer), on_nut, width, r)
    row, B = (np.concatenate(x, axis=1) for x in zip(*pieces, strict=True))
    shaft = nodes, structure.sections[0], structure.fixed[:n], structure.prescribed[:n], structure.load[:n], node, B[:, :2]
    problem = statics_problem.Problem(scene, layout, drawn, *shaft, geometry, closure, used, 0)
    return BallSet(rolling, problem, slice(first_ball, first_ball + N), outer, row, B, v0)


def interpolate_shaft_motions(structure: Structure, stations: Array) -> tuple[Ints, Array]:
    """Interpolate the motions of the shaft between its nodes at k axial positions.

    Returns the first node ``(k,)`` of the beam element at each position, and the matrices ``(k, 6, 12)`` that give the six
    motions there from the twelve motions of the element's two nodes.

    Parameters
    ----------
    structure
        Shaft, housings and springs.
    stations
        Axial positions ``(k,)`` [m].
    """
    nodes = structure.nodes
    element = np.clip(np.searchsorted(nodes, stations, side="right") - 1, 0, nodes.size - 2)
    sections = [structure.sections[e] for e in element]
    EA, EI, GJ, kGA = np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in sections]).T
    return beam_interpolation_matrices(stations, nodes, BeamSection(EA, EI, GJ, kGA))


def pad_coefficients_to_two_bodies(body: Ints, B: Array, width: int, body_count: int) -> tuple[Ints, Array]:
    """Pad the coefficients of one body's six motions with zeros to the twelve motions of two consecutively numbered bodies.

    The kernels store for every flank the coefficients of the motions of two bodies, although only one of them moves the
    flank. The body that moves it is the first of the pair; only the last of all bodies is the second of its pair. Returns
    the number of the first body of each pair, and the padded coefficients.

    Parameters
    ----------
    body
        Number of the body (shaft node or housing) that moves each flank; -1 if the flank is fixed.
    B
        Motion of each flank per unit of the body's six motions ``(..., 6)``. With ``width`` 6, ``body`` and ``B`` are
        returned unchanged.
    width
        Number of columns to return, 6 or 12.
    body_count
        Number of all bodies: shaft nodes and moving housings.
    """
    if B.shape[-1] == width:
        return body, B
    last = body == body_count - 1
    first, second = (np.concatenate(x, axis=-1) for x in ((B, np.zeros_like(B)), (np.zeros_like(B), B)))
    return body - last, np.where(last[..., None, None], second, first)


def replace_lever_arms(system: AssemblyArrays, arms: Sequence[Array]) -> AssemblyArrays:
    """Return the arrays of an assembly with new lever arms of the contact forces and unchanged Hertz constants.

    Parameters
    ----------
    system
        Arrays of the assembly.
    arms
        For each ball nut or ball bearing, the shifts ``(N, 4, 2)`` [m] of its flanks' centres of curvature by profile
        errors; contact forces act through these centres.
    """
    balls = []
    for b, arm in zip(system.ball_sets, arms, strict=True):
        p, first = b.problem, b.ball_indices.start
        longer = _build_ball_set(b.of, p.scene, system.structure, p.used_flanks, (p.layout, p.drawn), first, arm)
        longer.problem.C[:] = p.C
        balls.append(longer)
    limit = system.ball_arrays.unloaded_force_limit
    return replace(system, ball_sets=balls, ball_arrays=_concatenate_balls(balls)._replace(unloaded_force_limit=limit))


def contact_states_of_sets(system: AssemblyArrays, state: MotionState, shifts: Array | None = None) -> list[ContactState]:
    """Return contact forces, ball centres and flank motions of each ball nut and ball bearing.

    Parameters
    ----------
    system
        Arrays of the assembly.
    state
        Solved motions, ball centres and contacts.
    shifts
        Motions ``(N, 4, 2)`` [m] of the flanks of all balls; None: computed from the motions in ``state``.
    """
    moved = [flank_motions_of_set(b, state.q) if shifts is None else shifts[b.ball_indices] for b in system.ball_sets]
    return [
        ContactState(b.problem, state.contact[b.ball_indices], state.p[b.ball_indices], m)
        for b, m in zip(system.ball_sets, moved, strict=True)
    ]


def flank_motions_of_set(ball_set: BallSet, q: Array) -> Array:
    """Return the motions ``(N, 4, 2)`` [m] of the flanks of one ball nut or bearing, prescribed offsets included.

    Parameters
    ----------
    ball_set
        The ball nut or bearing, with N balls.
    q
        Motions ``(r, 6)`` [m, rad] of the r bodies: shaft nodes and moving housings.
    """
    return np.asarray(ball_set.v0 + ball_set.flank_motions(q))


def _concatenate_balls(sets: list[BallSet]) -> AxisBalls:
    """Concatenate the arrays of the balls of all nuts and bearings for the kernels.

    The contact data ``geometry`` of each problem in ``sets`` is replaced by a view of the joint array, so that both see an
    update of the Hertz constants. The polynomials of the flanks' profile errors are padded with zeros to the same degree.
    """
    problems = [b.problem for b in sets]
    degree = max((p.drawn.profile_coefficients.shape[1] for p in problems), default=0)
    profiles = []
    for p in problems:
        terms = np.zeros((len(p.C), 4, degree))
        terms[..., : p.drawn.profile_coefficients.shape[1]] = p.drawn.profile_coefficients
        profiles.append(terms)

    def concatenated(arrays: Sequence[NDArray[Any]], shape: tuple[int, ...]) -> NDArray[Any]:
        """Return arrays ``(N_i, *shape)`` concatenated along the first axis, also if there are none."""
        return np.ascontiguousarray(np.concatenate([np.zeros((0, *shape)), *arrays]))

    geometry = concatenated([p.geometry for p in problems], (4, 9))
    for b in sets:  # a view, so that an update of Hertz constants is seen in both places
        b.problem = replace(b.problem, geometry=geometry[b.ball_indices])
    return AxisBalls(
        first_bodies=concatenated([b.first_body_rows for b in sets], (4,)).astype(np.int64),
        B=concatenated([b.B for b in sets], (4, 2, sets[0].B.shape[3] if sets else 6)),
        v0=concatenated([b.v0 for b in sets], (4, 2)),
        geometry=geometry,
        interference=concatenated([p.interference for p in problems], (2,)),
        r_ball=concatenated([p.drawn.ball_radii for p in problems], ()),
        profile=concatenated(profiles, (4, degree)),
        unloaded_force_limit=0.0,
    )


def _build_roller_set(rolling: RollingSet, row: RollerRow, structure: Structure, first_slice: int) -> RollerSet:
    """Return the roller slices of one tapered roller bearing as arrays for the kernels.

    ``rolling``: the bearing with its position and housing; ``row``: dimensions of its rollers and raceways;
    ``first_slice``: index of its first slice among the slices of all bearings. The slices lie along the raceway of the
    cup (outer ring). Cone (inner ring) and cup approach each other along the normal of the cup's raceway. The forces of
    cone raceway and rib on a roller add up to a force on the line of action of the cup's force (`lowfi.rollers`).
    ``structure``: shaft and housings, whose motions move cone and cup.
    """
    n, bearing = structure.nodes.size, tapered_bearing_of_row(row)
    inner = int(np.abs(structure.nodes - rolling.position).argmin())
    outer = -1 if rolling.housing is None else structure.housing_numbers[rolling.housing]
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
    at_cup = float(structure.housing_positions[outer - n]) if outer >= 0 else rolling.position
    B = np.empty((row.count, row.slices, 2, 6))
    for end, (at, direction) in enumerate(((float(structure.nodes[inner]), 1.0), (at_cup, -1.0))):
        arm = point - np.array([0.0, 0.0, at])
        B[:, :, end, :3], B[:, :, end, 3:] = direction * normal, direction * np.cross(arm, normal)
    law, count = bearing.approach_law(), row.count * row.slices
    bodies = np.tile([inner, outer], (count, 1)).astype(np.int64)
    gap = np.tile(place**2 / row.crown, row.count) + sign * sin * rolling.offset
    width, g, s = (np.full(count, float(x)) for x in (row.length / row.slices, law.g, law.s))
    arrays = AxisRollers(bodies, B.reshape(count, 2, 6), gap, width, g, s)
    return RollerSet(rolling, row, slice(first_slice, first_slice + count), azimuths, arrays)


def _concatenate_rollers(sets: list[RollerSet]) -> AxisRollers:
    """Concatenate the arrays of the roller slices of all roller bearings."""
    if not sets:
        none = np.zeros(0)
        return AxisRollers(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2, 6)), none, none, none, none)
    fields = zip(*(r.slice_arrays for r in sets), strict=True)
    return AxisRollers(*(np.ascontiguousarray(np.concatenate(x)) for x in fields))


def _kernel_arrays_of_structure(structure: Structure, contacts: AxisBalls, slices: AxisRollers) -> AxisArrays:
    """Return the kernels' arrays of shaft, housings and springs, with the envelope of their stiffness matrix.

    ``contacts`` (balls) and ``slices`` (of rollers) determine which bodies are coupled. The envelope stores each row
    of the matrix from its first coefficient that can differ from zero to the diagonal. To keep it small, each housing is
    numbered right after the last shaft node with which it shares a contact.
    """
    n, r = structure.nodes.size, structure.body_positions.size
    used, movers = contacts.geometry[..., 5] > 0.0, contacts.first_bodies
    pairs = ([a, b] for a in range(4) for b in range(a))
    joined = [movers[:, p][used[:, p].all(axis=1) & (movers[:, p] >= 0).all(axis=1)] for p in pairs]
    if contacts.B.shape[3] > 6:
        joined = [x + np.array(step) for x in joined for step in np.ndindex(2, 2)]
    met = np.concatenate([*joined, slices.ring_bodies[(slices.ring_bodies >= 0).all(axis=1)]])
    springs = structure.spring_bodies[(structure.spring_bodies >= 0).all(axis=1)]
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
    constants = np.array([element_constants(*x) for x in zip(lengths, sections, strict=True)])
    beam = lengths, sections, constants, structure.fixed, structure.load
    joints = structure.spring_bodies, structure.spring_end_matrices, structure.springs
    return AxisArrays(*beam, *joints, body_order=place, first_columns=first, row_offsets=start)


def mean_pair_constant(ball_set: BallSet) -> float:
    """Return the Hertz constant C [m/N^(2/3)] of a ball's contacts with two opposite flanks in series, mean of all balls.

    At a contact force Q, screw and nut (or the rings) approach each other by C Q^(2/3) across the ball.
    """
    C = ball_set.problem.C
    return float(np.mean(C[:, 0] + C[:, 3]))


def preload_approach(ball_set: BallSet) -> float:
    """Return the contact approach [m] that preload alone causes in a ball nut or bearing while all bodies are fixed.

    Preload comes from oversized balls, or from the prescribed axial offset of the nut or outer ring. The approaches of both
    contacts of a ball are added up.
    """
    problem, offset = ball_set.problem, ball_set.of.offset
    shift = {"+z": -offset, "-z": offset}.get(ball_set.of.thrust, abs(offset))
    return max(statics_problem.largest_interference(problem), shift * float(np.sin(problem.scene.track.contact_angle)))


def mean_load_per_rolling_element(system: AssemblyArrays) -> float:
    """Return the sum of the magnitudes of all external loads, divided by the number of balls and rollers [N].

    Loads on shaft and housings count, thermal loads do not. Moments count as moment divided by the largest pitch radius.
    """
    bodies: tuple[Load | Housing, ...] = (*system.assembly.loads, *system.assembly.housings)
    applied = sum(np.abs(x.force).sum() + np.abs(x.moment).sum() / system.moment_arm for x in bodies)
    return float(applied) / max(1, system.ball_arrays.r_ball.size + sum(r.row.count for r in system.roller_sets))


def typical_contact_force(system: AssemblyArrays, ball_set: BallSet) -> float:
    """Return the force [N] of a typical contact of the ball nut or bearing ``ball_set``, at least 1e-6 N.

    The force is the larger of the mean load of a rolling element and the preload of a contact. If there are neither loads
    nor preload but prescribed displacements, it is the force at an approach of 1 um.
    """
    pair = mean_pair_constant(ball_set)
    force = max(mean_load_per_rolling_element(system), float(contact_force(preload_approach(ball_set), pair)))
    if force == 0.0 and np.any(system.structure.prescribed):
        force = float(contact_force(1e-6, pair))
    return max(force, 1e-6)


def assembly_residual_scale(system: AssemblyArrays) -> ResidualScale:
    """Return typical force and stiffness of the assembly's contacts, and the force below which a contact is unloaded.

    The solver scales residuals by these values. A contact counts as unloaded below 1e-14 of the typical force. If neither
    loads nor preload press any contact, this limit is the force at an approach of the size of the coordinates' round-off.
    """
    load, share = system.structure.load, mean_load_per_rolling_element(system)
    stiffness, squeezed = 1.0, 0.0
    for b in system.ball_sets:
        pair = mean_pair_constant(b)
        squeezed = max(squeezed, float(contact_force(preload_approach(b), pair)))
        if share == 0.0 and squeezed == 0.0 and np.any(system.structure.prescribed):
            squeezed = float(contact_force(1e-6, pair))
    force = max(share, squeezed)
    for b in system.ball_sets:
        stiffness = max(stiffness, float(np.cbrt(force) / mean_pair_constant(b)) if force > 0.0 else 1.0)
    for r in system.roller_sets:
        law, length = r.slice_arrays, r.row.length
        stiffness = max(stiffness, length / r.row.slices / float(law.g[0] - law.s[0] * np.log(max(force, 1.0) / length)))
    floor = max(float(np.abs(load[:, :3]).max()), float(np.abs(load[:, 3:]).max()) / system.moment_arm, squeezed)
    none = 1e-14 * force
    if force == 0.0:
        touch = statics_problem.round_off_approach
        none = max((float(contact_force(touch(b.problem), mean_pair_constant(b))) for b in system.ball_sets), default=0.0)
    return ResidualScale(force, stiffness, floor, none)


@dataclass(frozen=True)
class RollerElements:
    """The M rollers of all roller bearings, each as one element between rigid cone (inner ring) and cup (outer ring)."""

    #: Number of the shaft node on which each roller's cone sits ``(M,)``.
    cone_nodes: NDArray[np.int64]
    #: Number of the housing of each roller's cup among the bodies (shaft nodes, then moving housings) ``(M,)``; -1 if it is
    #: fixed.
    cup_body_rows: NDArray[np.int64]
    #: Motions of cone and cup at each roller per unit motion of shaft node or housing ``(M, 2, 2, 6)``. The axes are:
    #: roller; cone or cup; displacement along the contact normal at the roller's middle, or its slope along the roller
    #: times the roller's length; the six motions of the shaft node (cone) or housing (cup).
    B: Array
    #: Positions, widths and gaps of the rollers' slices, and their force law.
    roller_contacts: RollerContacts

    @property
    def count(self) -> int:
        """Return the number M of rollers of all roller bearings."""
        return self.cone_nodes.size


def roller_elements(sets: list[RollerSet]) -> RollerElements:
    """Return the rollers of all roller bearings as elements between their rigid rings, one bearing after the other.

    ``sets``: the roller bearings.
    """
    M, K = sum(r.row.count for r in sets), max((r.row.slices for r in sets), default=0)
    node, outer = np.zeros(M, dtype=np.int64), np.full(M, -1, dtype=np.int64)
    B, law = np.zeros((M, 2, 2, 6)), np.zeros((2, M))
    place, width, drop = np.zeros((3, M, K))
    first = 0
    for r in sets:
        a, n, count = r.slice_arrays, r.row.slices, r.row.count
        mine = slice(first, first + count)
        first = mine.stop
        x = slice_middles(r.row.length, n) / r.row.length
        rows = a.B.reshape(count, n, 2, 6) * np.array([1.0, -1.0])[:, None]  # lin: approach; here: motion
        base = np.linalg.pinv(np.column_stack([np.ones(n), x])) if n > 1 else np.array([[1.0], [0.0]])
        B[mine] = np.einsum("ak,ikej->ieaj", base, rows)
        place[mine, :n] = x
        width[mine, :n], drop[mine, :n] = a.width.reshape(-1, n), a.gap.reshape(-1, n)
        law[0, mine], law[1, mine] = a.g[0], a.s[0]
        node[mine], outer[mine] = a.ring_bodies[0]
    return RollerElements(node, outer, B, RollerContacts(place, width, drop, *law))


def starting_spring_factors_of_rollers(count: int, stiffness: float) -> Array:
    """Return factors S ``(count, 2, 8)`` of the stiffness of linear springs that replace the rollers in the first solve.

    S^T S [N/m] is the stiffness of a spring between cone and cup (inner and outer ring), at the middle of a roller,
    against the eight motions of these two rings. `lowfi.statics.response.starting_spring_factors` returns the springs
    of balls in the same layout.

    Parameters
    ----------
    count
        Number of rollers.
    stiffness
        Stiffness of each spring [N/m].
    """
    rows = np.zeros((count, 2, 8))
    rows[:, 0, 0], rows[:, 0, 4] = np.sqrt(stiffness), -np.sqrt(stiffness)
    return rows


def location_of_reported_stiffness(assembly: Assembly) -> float | str:
    """Return where an assembly's stiffness is reported: an axial position on the shaft [m], or the name of a housing.

    It is the location ``stiffness_at`` of the assembly; if that is None, the first loaded housing, else the position of the
    first load on the shaft, else the position of the first bearing or nut.

    Parameters
    ----------
    assembly
        Shaft with several bearings or nuts.
    """
    if assembly.stiffness_at is not None:
        return assembly.stiffness_at
    loaded = [h.name for h in assembly.housings if any(h.force) or any(h.moment)]
    if loaded:
        return loaded[0]
    return assembly.loads[0].at if assembly.loads else assembly.sets[0].position


def body_of_reported_stiffness(system: AssemblyArrays) -> int:
    """Return the number of the shaft node or housing whose stiffness is reported; -1 for a fixed housing."""
    at, s = location_of_reported_stiffness(system.assembly), system.structure
    return s.housing_numbers[at] if isinstance(at, str) else int(np.abs(s.nodes - at).argmin())


def describe_left_out_flanks(system: AssemblyArrays) -> tuple[str, ...]:
    """Return, for each nut or bearing with flanks that the equations leave out, a sentence that names these flanks."""
    notes = []
    for b in system.ball_sets:
        idle = [SIDES[k] for k in np.flatnonzero(USE[b.of.thrust] & ~b.problem.used_flanks)]
        if idle:
            notes.append(f"{b.of.name}: flanks {' and '.join(idle)} left out: load or offset lifts them off every ball")
    return tuple(notes)
