"""Arrays of a shaft with several bearings and ball nuts: balls, rollers, beam and springs.

A *set* is one bearing row or one ball nut. A *motion row* holds the six motions (three translations, three rotations) of
one shaft node or one moving housing; `Structure` numbers these rows.

A roller is one element between two rigid rings. The approach of each slice of the roller is the approach at the roller's
middle plus the slice's position times the slope along the roller. Two motions at each ring therefore determine all slices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_force
from rollbench.lowfi.rollers import slice_middles, tapered_bearing_of_row
from rollbench.lowfi.statics import problem as statics_problem
from rollbench.lowfi.statics.axis.structure import Structure, build_structure
from rollbench.lowfi.statics.rolling_elements import Balls, Rollers
from rollbench.lowfi.statics.settle import ResidualScale
from rollbench.lowfi.statics.shape import beam_interpolation_matrices
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import Load, Scene
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
    #: Indices of the rollers of this bearing among those of all roller bearings.
    roller_indices: slice
    #: Azimuths of the rollers ``(count,)`` [rad].
    roller_azimuths: Array
    #: Numbers of the bodies (shaft node or housing) that carry cone and cup; -1 if the cup is fixed.
    ring_bodies: tuple[int, int]
    #: Motions of cone and cup at each roller per unit motion of the bodies that carry them ``(count, 2, 2, 6)``. The axes
    #: are: roller; cone or cup; displacement along the contact normal at the roller's middle, or its slope along the roller
    #: times the roller's length; the six motions of the body.
    B: Array
    #: Positions, widths and gaps of the rollers' slices, and their force law.
    rollers: Rollers

    def slice_motions(self, ring: int) -> Array:
        """Return the motions of cone (``ring`` 0) or cup (1) at all slices per unit motion of their body ``(K, 6)``."""
        middle, slope = self.B[:, ring, :, None].swapaxes(0, 1)
        return np.asarray(middle + self.rollers.positions[0, :, :, None] * slope).reshape(-1, 6)


@dataclass
class AssemblyArrays:
    """Shaft with its bearings, ball nuts and housings as arrays."""

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
    #: All balls, as one member and rigid apart from their Hertz contacts.
    balls: Balls = field(repr=False)
    #: Prescribed motion of the flanks of all balls ``(N, 4, 2)`` [m] by axial offsets of nuts and outer rings.
    prescribed_flank_motions: Array = field(repr=False)

    @property
    def ball_count(self) -> int:
        """Return the number N of all balls."""
        return int(self.balls.C.shape[1])

    @property
    def roller_count(self) -> int:
        """Return the number of all rollers."""
        return sum(r.row.count for r in self.roller_sets)


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


def build_assembly_arrays(assembly: Assembly, member: int = 0, section: BeamSection | None = None) -> AssemblyArrays:
    """Return an assembly (shaft, bearings, ball nuts and housings) as arrays.

    A flank gets contacts if thrust in the direction that its nut or bearing carries can load it.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    member
        Number of the specimen: each number gives other random errors.
    section
        Cross-section of the threaded shaft; None: computed from the assembly's dimensions.

    Raises
    ------
    ValueError
        If the dimensions leave no shaft, or two supports fix the same degree of freedom.
    """
    parts = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, Scene)]
    rows = [(s, s.parts) for s in assembly.sets if isinstance(s.parts, RollerRow)]
    placed = ball_positions_with_errors(assembly, member)
    stations = [
        contact_force_positions(scene, layout)[:, USE[s.thrust][:2]].ravel()
        for (s, scene), (layout, _) in zip(parts, placed, strict=True)
        if s.carrier is None
    ]
    structure = build_structure(assembly, np.concatenate([[s.position for s, _ in rows], *stations]), section)
    first_balls = accumulate((layout.z.size for layout, _ in placed), initial=0)
    balls = [
        _build_ball_set(of, scene, structure, place, first)
        for (of, scene), place, first in zip(parts, placed, first_balls, strict=False)
    ]
    first_rollers = accumulate((row.count for _, row in rows), initial=0)
    rollers = [_build_roller_set(of, row, structure, first) for (of, row), first in zip(rows, first_rollers, strict=False)]
    arm = max(
        [scene.track.pitch_radius for _, scene in parts]
        + [tapered_bearing_of_row(row).pitch_diameter / 2.0 for _, row in rows]
    )
    return AssemblyArrays(assembly, structure, balls, rollers, arm, *_all_balls(balls))


def _build_ball_set(
    rolling: RollingSet, scene: Scene, structure: Structure, place: Placed, first_ball: int, arms: Array | None = None
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
    place
        Positions of the balls, and dimensions with their random manufacturing errors.
    first_ball
        Index of the first ball among all balls of the assembly.
    arms
        Shifts of the flanks' centres of curvature by profile errors ``(N, 4, 2)`` [m]; None: zero.
    """
    (layout, drawn), used = place, USE[rolling.thrust]
    parts = (scene, drawn, layout, arms)
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
    of_bodies = structure.fixed[:n], structure.prescribed[:n], structure.load[:n]
    shaft = nodes, *of_bodies, node, B[:, :2], structure.sections[0], scene.track.pitch_radius, scene.nut.position
    balls = statics_problem.nominal_balls(scene, drawn, used)
    problem = statics_problem.Problem(*shaft, scene=scene, layout=layout, drawn=drawn, balls=balls, used_flanks=used)
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

    The arrays hold for every flank the coefficients of the motions of two bodies, although only one of them moves the
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
        longer = _build_ball_set(b.of, p.scene, system.structure, (p.layout, p.drawn), first, arm)
        longer.problem.C[:] = p.C
        balls.append(longer)
    every, motions = _all_balls(balls)
    return replace(system, ball_sets=balls, balls=every, prescribed_flank_motions=motions)


def _all_balls(sets: list[BallSet]) -> tuple[Balls, Array]:
    """Return the balls of all nuts and bearings as one member, and the prescribed motions of their flanks.

    The contacts of each problem in ``sets`` become views of the joint arrays, so that both see an update of the Hertz
    constants. The polynomials of the flanks' profile errors are padded with zeros to the same degree.
    """
    balls = Balls.joined([b.problem.balls for b in sets])
    for b in sets:
        b.problem = replace(b.problem, balls=replace(b.problem.balls, C=balls.C[:, b.ball_indices]))
    return balls, np.concatenate([np.zeros((0, 4, 2)), *(b.v0 for b in sets)])


def _build_roller_set(rolling: RollingSet, row: RollerRow, structure: Structure, first_roller: int) -> RollerSet:
    """Return the rollers of one tapered roller bearing as arrays.

    ``rolling``: the bearing with its position and housing; ``row``: dimensions of its rollers and raceways;
    ``first_roller``: index of its first roller among those of all bearings. The slices lie along the raceway of the
    cup (outer ring). Cone (inner ring) and cup approach each other along the normal of the cup's raceway. The forces of
    cone raceway and rib on a roller add up to a force on the line of action of the cup's force (`lowfi.rollers`).
    ``structure``: shaft and housings, whose motions move cone and cup.
    """
    n, bearing = structure.nodes.size, tapered_bearing_of_row(row)
    inner = int(np.abs(structure.nodes - rolling.position).argmin())
    outer = -1 if rolling.housing is None else structure.housing_numbers[rolling.housing]
    sign = 1.0 if rolling.thrust == "+z" else -1.0
    sin, cos = np.sin(row.cup_angle), np.cos(row.cup_angle)
    azimuths = row.phase + 2.0 * np.pi * np.arange(row.count) / row.count
    c, s, one_each = np.cos(azimuths), np.sin(azimuths), np.ones(row.count)
    normal = np.stack([cos * c, cos * s, sign * sin * one_each], axis=1)
    along = np.stack([sin * c, sin * s, -sign * cos * one_each], axis=1)
    middle = bearing.apex_distance * sin * np.stack([c, s, 0.0 * c], axis=1) + np.array([0.0, 0.0, rolling.position])
    at_cup = float(structure.housing_positions[outer - n]) if outer >= 0 else rolling.position
    ends = middle + row.length * np.array([-0.5, 0.5])[:, None, None] * along
    B = np.empty((row.count, 2, 2, 6))
    for ring, at in enumerate((float(structure.nodes[inner]), at_cup)):
        turned = np.cross(ends - [0.0, 0.0, at], normal)
        low, high = np.concatenate([np.broadcast_to(normal, turned.shape), turned], axis=2)
        B[:, ring] = np.stack([0.5 * (low + high), high - low], axis=1)
    law, place = bearing.approach_law(), slice_middles(row.length, row.slices)
    gaps = place**2 / row.crown + sign * sin * rolling.offset
    slices = (
        np.tile(x, (1, row.count, 1)) for x in (place / row.length, np.full(row.slices, row.length / row.slices), gaps)
    )
    rollers = Rollers(*slices, *(np.full((1, row.count), float(x)) for x in (law.g, law.s)))
    own = slice(first_roller, first_roller + row.count)
    return RollerSet(rolling, row, own, azimuths, (inner, outer), B, rollers)


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
    closed = float(problem.balls.interference.max(initial=0.0))
    squeezed = closed if closed > statics_problem.round_off_approach(problem) else 0.0
    return max(squeezed, shift * float(np.sin(problem.scene.track.contact_angle)))


def mean_load_per_rolling_element(system: AssemblyArrays) -> float:
    """Return the sum of the magnitudes of all external loads, divided by the number of balls and rollers [N].

    Loads on shaft and housings count, thermal loads do not. Moments count as moment divided by the largest pitch radius.
    """
    bodies: tuple[Load | Housing, ...] = (*system.assembly.loads, *system.assembly.housings)
    applied = sum(np.abs(x.force).sum() + np.abs(x.moment).sum() / system.moment_arm for x in bodies)
    return float(applied) / max(1, system.ball_count + system.roller_count)


def typical_contact_forces(system: AssemblyArrays, known: Sequence[float] | None = None) -> list[float]:
    """Return the force [N] of a typical contact of each ball nut and bearing with balls; 0 where nothing presses it.

    The force is the largest of the mean load of a rolling element, the preload of a contact, and what a solution tells.

    Parameters
    ----------
    system
        Arrays of the assembly.
    known
        For each of these nuts and bearings the least typical force [N] by a solution. None: in its place stands the force
        that heating of a shaft between rigid bearings causes, and that at an approach as large as the largest prescribed
        displacement. Both are upper bounds, as bodies and supports yield.
    """
    structure, share = system.structure, mean_load_per_rolling_element(system)
    pairs = [mean_pair_constant(b) for b in system.ball_sets]
    if known is None:
        push = max((s.EA for s in structure.sections), default=0.0) * abs(system.assembly.thermal_strain)
        moved = np.abs(structure.prescribed) * np.repeat([1.0, system.moment_arm], 3)
        given = float(moved.max(initial=0.0))
        known = [
            max(push / b.problem.layout.z.size, float(contact_force(given, c)))
            for b, c in zip(system.ball_sets, pairs, strict=True)
        ]
    squeezed = [float(contact_force(preload_approach(b), c)) for b, c in zip(system.ball_sets, pairs, strict=True)]
    return [max(share, own, found) for own, found in zip(squeezed, known, strict=True)]


def assembly_residual_scale(system: AssemblyArrays, known: Sequence[float] | None = None) -> ResidualScale:
    """Return typical force and stiffness of the assembly's contacts, and the force below which a contact is unloaded.

    The solver scales residuals by these values. A contact counts as unloaded below 1e-14 of the typical force. If neither
    loads nor preload nor prescribed displacements press any contact, this limit is the force at an approach of the size of
    the coordinates' round-off. ``known``: see `typical_contact_forces`.
    """
    load, share = system.structure.load, mean_load_per_rolling_element(system)
    squeezed = [float(contact_force(preload_approach(b), mean_pair_constant(b))) for b in system.ball_sets]
    forces, stiffness = typical_contact_forces(system, known), 1.0
    force = max([share, *forces])
    for b in system.ball_sets:
        stiffness = max(stiffness, float(np.cbrt(force) / mean_pair_constant(b)) if force > 0.0 else 1.0)
    for r in system.roller_sets:
        law, length = r.rollers, r.row.length
        slope = float(law.g[0, 0] - law.s[0, 0] * np.log(max(force, 1.0) / length))
        stiffness = max(stiffness, length / r.row.slices / slope)
    tightest = max(squeezed, default=0.0)
    floor = max(float(np.abs(load[:, :3]).max()), float(np.abs(load[:, 3:]).max()) / system.moment_arm, tightest)
    none = 1e-14 * force
    if max(share, tightest) == 0.0 and not (force > 0.0 and np.any(system.structure.prescribed)):
        touch = statics_problem.round_off_approach
        none = max((float(contact_force(touch(b.problem), mean_pair_constant(b))) for b in system.ball_sets), default=0.0)
    return ResidualScale(force, stiffness, floor, none)


def all_rollers(sets: list[RollerSet]) -> Rollers | None:
    """Return the rollers of all roller bearings as one record; those with fewer slices than others get slices of no width.

    ``sets``: the roller bearings; without any, None is returned.
    """
    if not sets:
        return None
    most, each = max(r.row.slices for r in sets), []
    for of in (r.rollers for r in sets):
        more = ((0, 0), (0, 0), (0, most - of.widths.shape[2]))
        each.append((*(np.pad(x, more) for x in (of.positions, of.widths, of.gaps)), of.g, of.s))
    return Rollers(*(np.concatenate(x, axis=1) for x in zip(*each, strict=True)))


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
