"""Arrays of the static problem of one ball screw, and a check whether supports of a rigid screw contradict each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice
from rollbench.lowfi.statics.rolling_elements import Balls
from rollbench.lowfi.statics.shape import beam_interpolation_matrices, right_singular_vectors, rigid_motion_transfer_matrix
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.axis import Housing
from rollbench.meshes.errors import GeometriesWithErrors, GeometryWithErrors
from rollbench.meshes.helix import BallLayout, nominal_contact_points, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import FREEDOMS, Scene, Support
from rollbench.meshes.section import MERGE, BeamSection, beam_nodes, contact_force_positions, screw_section

#: Scene; dimensions of the parts with errors; ball positions; and shifts ``(N, 4, 2)`` [m] of the flanks' centres of
#: curvature by profile errors (None: zero).
Parts = tuple[Scene, GeometryWithErrors, BallLayout, Array | None]


@dataclass(frozen=True)
class BeamProblem:
    """What the beam of a shaft with n nodes needs to know of all N rolling elements on it.

    The motion of a groove flank at a ball depends on m motions of nodes: six of one node, or twelve of two nodes. In the
    axes of the arrays rollers follow the balls.
    """

    #: Axial positions of the beam's nodes ``(n,)`` [m].
    nodes: Array
    #: Which degrees of freedom of the nodes are fixed ``(n, 6)``.
    fixed: Mask
    #: Prescribed values of the fixed degrees of freedom ``(n, 6)`` [m, rad].
    prescribed: Array
    #: Loads on the nodes ``(n, 6)`` [N, N m].
    load: Array
    #: Number of the first node whose motion moves the screw's left and right flank at each ball ``(N, 2)``.
    first_nodes: NDArray[np.int64]
    #: Motions of the screw's two flanks at each ball, radial and along the helix's binormal, per unit of the six motions of
    #: the node in ``first_nodes`` (m = 6), or of the motions of this node and the next one (m = 12): ``(N, 2, 2, m)``.
    B: Array
    #: Cross-section of the screw.
    section: BeamSection
    #: Length [m] by which moments are divided where they are compared with forces: for a single screw its pitch radius.
    moment_arm: float
    #: Axial position [m] near the middle of the contacts: for a single screw the nut's centre.
    middle: float
    #: Cross-section of every beam element; None: ``section`` everywhere.
    element_sections: tuple[BeamSection, ...] | None = None
    #: For a rigid screw, the matrix ``(6, 6)`` from its six coordinates (the free ones first, then those that supports fix)
    #: to its three displacements and three rotations; None for a beam.
    rigid_motion_basis: Array | None = None


@dataclass(frozen=True, kw_only=True)
class Problem(BeamProblem):
    """Arrays of the static problem of a ball screw with n beam nodes and N balls."""

    #: Description of screw, nut, balls, supports and loads.
    scene: Scene
    #: Positions of the balls.
    layout: BallLayout
    #: Dimensions of screw, nut and balls with their manufacturing errors.
    drawn: GeometryWithErrors
    #: All balls between rigid bodies before anything moves, as one member. An update of their Hertz constants writes to
    #: this record's array.
    balls: Balls
    #: Which of the four flanks (screw left, screw right, nut left, nut right) have contacts ``(4,)``.
    used_flanks: Mask
    #: Number of beam elements at the ends of the screw that are left out because they carry no load.
    left_out_elements: int = 0
    #: Numbers of the degrees of freedom of the first node (for a rigid screw, of its coordinates, the columns of
    #: ``rigid_motion_basis``) that the model fixes although no support does, because no load drives these motions and
    #: nothing resists them.
    pins: tuple[int, ...] = ()

    @property
    def C(self) -> Array:
        """Return the Hertz constants C ``(N, 4)`` [m/N^(2/3)] (approach = C Q^(2/3) at force Q) of ``balls``."""
        C: Array = self.balls.C[0]
        return C

    @property
    def unknowns(self) -> int:
        """Return the number of unknown motions of the screw; the balls' positions are eliminated and do not count."""
        return int(np.count_nonzero(~self.fixed))


class ContactState(NamedTuple):
    """Contact forces, ball centres and flank motions of one bearing or nut with N balls, in one state of the iteration."""

    #: Contact problem of the bearing or nut.
    problem: Problem
    #: Force of each contact ``(N, 4)`` [N].
    force: Array
    #: Unit normal of each contact from ball to groove ``(N, 4, 2)``.
    normal: Array
    #: Stiffness of each contact across its normal ``(N, 4)`` [N/m]: force times the curvature of the flank.
    tangential: Array
    #: Displacements of the ball centres in their section planes ``(N, 2)`` [m].
    ball_centres: Array
    #: Motions of all flanks in the balls' section planes ``(N, 4, 2)`` [m].
    flank_motions: Array


@dataclass(frozen=True)
class SolvedState:
    """Solution of a static problem with n beam nodes and N balls: contacts, motions and support reactions."""

    #: Contacts of all balls, with the problem that was solved.
    contacts: ContactState
    #: Motions of the beam's nodes ``(n, 6)`` [m, rad].
    nodal_motions: Array
    #: Forces and moments of the supports on the nodes ``(n, 6)`` [N, N m]. They are zero for a rigid screw, whose reactions
    #: follow from its equilibrium.
    reactions: Array
    #: Force by which the solver divided its residual [N]: the largest force in the model.
    residual_force_scale: float


def nominal_balls(scene: Scene, drawn: GeometryWithErrors, use: Mask) -> Balls:
    """Return the balls between rigid bodies before anything moves, as one member.

    Parameters
    ----------
    scene
        Nominal screw, nut and balls.
    drawn
        Dimensions of the parts with their manufacturing errors.
    use
        Which of the four flanks (screw left, screw right, nut left, nut right) have contacts ``(4,)``.
    """
    C, profile = hertz_constants_by_scene_choice(scene, drawn)[None], drawn.profile_coefficients
    zero = np.zeros(C.shape)
    return Balls(
        **{name: x[None] for name, x in place_balls(scene, drawn)._asdict().items()},
        C=C,
        used=np.broadcast_to(use, C.shape).copy(),
        e=zero,
        h=zero,
        body=zero,
        radius=drawn.ball_radii[None],
        groove_radius=np.broadcast_to(drawn.groove_radii, C.shape),
        profile=np.broadcast_to(profile, (*C.shape, profile.shape[-1])),
    )


class PlacedBalls(NamedTuple):
    """Where the balls of one specimen, or of many, lie between their groove flanks before anything moves.

    Axes: specimen (if there are many), ball, flank, component in the ball's section plane.
    """

    #: Vector from groove centre to ball centre ``(..., N, 4, 2)`` [m], and its length ``(..., N, 4)`` [m].
    to_ball: Array
    distance: Array
    #: Approach ``(..., N, 4)`` [m]: overlap of the undeformed ball and flank.
    approach: Array
    #: Interference ``(..., N, 2)`` [m] with the diagonal pairs of flanks, screw left and nut right, then screw right and
    #: nut left; negative for clearance.
    interference: Array


def place_balls(scene: Scene, drawn: GeometryWithErrors | GeometriesWithErrors) -> PlacedBalls:
    """Return where balls lie between their groove flanks.

    Approaches are computed from the differences between actual and nominal dimensions, so that parts without errors have an
    approach of exactly zero, and small errors lose no digits.

    Parameters
    ----------
    scene
        Nominal screw, nut and balls.
    drawn
        Dimensions of the parts with their manufacturing errors, of one specimen or many.
    """
    x, z, radii = drawn.groove_centres[..., 0], drawn.groove_centres[..., 1], nominal_groove_radii(scene)
    size, nominal = _vector_length(x, z), _vector_length(*nominal_groove_centres(scene).T)
    wider = (drawn.groove_radii - radii) + (radii - scene.balls.radius - nominal)
    shape = (*drawn.ball_radii.shape, 4)
    approach = (drawn.ball_radii - scene.balls.radius)[..., None] - wider + (size - nominal)
    to_ball, distance = np.empty((*shape, 2)), np.empty(shape)
    to_ball[...], distance[...] = -drawn.groove_centres, size
    closure = np.empty((*drawn.ball_radii.shape, 2))
    for a, b in ((0, 3), (1, 2)):  # pair by pair, over all balls: numpy is slow along short axes
        grown = _vector_length(x[..., a] - x[..., b], z[..., a] - z[..., b]) - size[..., a] - size[..., b]
        closure[..., a] = approach[..., a] + approach[..., b] + grown
    return PlacedBalls(to_ball, distance, np.asarray(approach), closure)


def round_off_approach(problem: Problem) -> float:
    """Return the contact approach [m] up to which a contact may be round-off: 16 machine epsilons times a ball radius.

    A contact with a computed approach up to this size counts as open.
    """
    return 16.0 * float(np.finfo(float).eps) * problem.scene.balls.radius


def _vector_length(x: Array, z: Array) -> Array:
    """Return the lengths of vectors (x, z).

    Unlike numpy's hypot, the rounding does not depend on where the arrays lie in memory.
    """
    return np.asarray(np.sqrt(x * x + z * z))


def flank_motion_matrix(parts: Parts, side: int, origin_z: Array) -> Array:
    """Return the matrix that gives the motion of a body's groove flank at each ball from the body's six motions.

    The motion is e . (u + theta x r), with displacement u and rotation theta of the body, lever arm r, and each of the two
    axes e of the ball's section plane. The arm ends at the groove's centre of curvature, because the force on a circular
    arc always acts through it. If the scene's key ``arm`` is "nominal", r ends at the nominal contact point instead.

    Parameters
    ----------
    parts
        Screw, nut and balls, see `Parts`.
    side
        Number of the flank in the order screw left, screw right, nut left, nut right.
    origin_z
        Axial position [m] of the point at which the body's motion is taken, for each ball ``(N,)``.

    Returns
    -------
    Array
        ``(..., N, 2, 6)``: both axes e of each ball's section, six motions.
    """
    scene, drawn, layout, arms = parts
    if scene.ingredients.arm == "nominal":
        point = np.broadcast_to(nominal_contact_points(scene)[side], (layout.z.size, 2))
    else:
        point = drawn.groove_centres[..., side, :] + (arms[:, side] if arms is not None else 0.0)
    x = layout.centre + point[..., :1] * layout.radial
    x += point[..., 1:] * layout.binormal
    x[..., 2] -= origin_z
    return point_motion_matrix(layout, x)


def point_motion_matrix(layout: BallLayout, r: Array) -> Array:
    """Return the matrix from a body's six motions to the motion of its points r, in each ball's section plane.

    The body's motion is taken at the origin of r. The rows are (e, r x e) for both axes e of the section plane.

    Parameters
    ----------
    layout
        Positions and section planes of the N balls.
    r
        Points ``(..., N, 3)`` [m] of the body.

    Returns
    -------
    Array
        ``(..., N, 2, 6)``.
    """
    rows = np.empty((*r.shape[:-1], 2, 6))
    rows[..., 0, :3], rows[..., 1, :3] = layout.radial, layout.binormal
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows[..., 3 + k] = r[..., i, None] * rows[..., j] - r[..., j, None] * rows[..., i]
    return rows


def flank_motions_of_specimens(problem: Problem, centre: Array) -> Array:
    """Return the motions of the screw's flanks per unit motion of the beam's nodes, for k specimens with groove errors.

    The result replaces `Problem.B`. Its axes are specimen, ball, screw flank (left, right), component in the ball's section
    plane, and node motion. Specimens differ in their lever arms, which end at the centres of groove arcs.

    Parameters
    ----------
    problem
        Static problem of one specimen, with N balls.
    centre
        Centres of the groove arcs of all specimens in the balls' section planes ``(k, N, 4, 2)`` [m].

    Returns
    -------
    Array
        ``(k, N, 2, 2, m)``, with m motions of one or two nodes.
    """
    parts = (problem.scene, replace(problem.drawn, groove_centres=centre), problem.layout, None)
    B = np.zeros((len(centre), *problem.B.shape))
    stations = contact_force_positions(problem.scene, problem.layout)
    for s in range(2):
        if problem.rigid_motion_basis is not None:
            at_origin = flank_motion_matrix(parts, s, np.full(len(stations), problem.nodes[0]))
            B[:, :, s] = at_origin @ problem.rigid_motion_basis
        elif problem.used_flanks[s] and B.shape[-1] == 6:
            B[:, :, s] = flank_motion_matrix(parts, s, problem.nodes[problem.first_nodes[:, s]])
        elif problem.used_flanks[s]:
            _, m = beam_interpolation_matrices(stations[:, s], problem.nodes, problem.section)
            B[:, :, s] = flank_motion_matrix(parts, s, stations[:, s]) @ m
    return B


def fixed_motions(bodies: int, supports: Iterable[tuple[int, Support | Housing]]) -> tuple[Mask, Array]:
    """Return which motions of shaft nodes and housings are fixed, and their values, ``(bodies, 6)`` each [m, rad].

    ``bodies``: number of shaft nodes and housings together. ``supports``: pairs of the number of a node or housing and the
    support that fixes it; a housing with fixed degrees of freedom counts as its own support.

    Raises
    ------
    ValueError
        If two supports fix the same degree of freedom of one body.
    """
    fixed, prescribed = np.zeros((bodies, 6), dtype=bool), np.zeros((bodies, 6))
    for j, support in supports:
        for name, value in support.fixed:
            k = FREEDOMS.index(name)
            if fixed[j, k]:
                raise ValueError(
                    f"got two supports that fix {name} at {1e3 * support.at:g} mm; allowed: one support for each degree of "
                    f"freedom within {1e6 * MERGE:g} um; remove one of them"
                )
            fixed[j, k], prescribed[j, k] = True, value
    return fixed, prescribed


def _nodal_supports_and_loads(scene: Scene, nodes: Array) -> tuple[Mask, Array, Array]:
    """Return the fixed degrees of freedom of the nodes, their prescribed values, and the nodal loads, ``(n, 6)`` each.

    Raises
    ------
    ValueError
        If two supports fix the same degree of freedom of one node.
    """
    fixed, prescribed = fixed_motions(nodes.size, ((int(np.abs(nodes - s.at).argmin()), s) for s in scene.supports))
    load = np.zeros((nodes.size, 6))
    for x in scene.loads:
        j = int(np.abs(nodes - x.at).argmin())
        load[j] += (*x.force, *x.moment)
        load[j, 3] -= (x.at - nodes[j]) * x.force[1]
        load[j, 4] += (x.at - nodes[j]) * x.force[0]
    return fixed, prescribed, load


def build_problem(
    scene: Scene,
    drawn: GeometryWithErrors,
    layout: BallLayout,
    use: Mask,
    *,
    everything: bool = False,
    refine: int = 1,
    arms: Array | None = None,
    section: BeamSection | None = None,
) -> Problem:
    """Return the arrays of the static problem of a ball screw.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    drawn
        Dimensions of the parts with their manufacturing errors.
    layout
        Positions of the balls.
    use
        Which of the four flanks (screw left, screw right, nut left, nut right) get contacts ``(4,)``.
    everything
        Whether to model also the ends of the shaft that carry no load.
    refine
        Number of elements that each beam element is split into.
    arms
        Shifts of the flanks' centres of curvature by profile errors ``(N, 4, 2)`` [m]; None: zero.
    section
        Cross-section of the screw; None: computed from the scene's dimensions (Lin C.8).

    Raises
    ------
    ValueError
        If supports contradict each other.
    """
    parts = (scene, drawn, layout, arms)
    balls = nominal_balls(scene, drawn, use)
    section = section or screw_section(scene)
    stations = contact_force_positions(scene, layout)
    used = [s for s in range(2) if use[s]]
    if scene.ingredients.screw == "rigid":
        return _build_rigid_problem(parts, use, balls, section)
    nodes, left_out = beam_nodes(scene, stations[:, used], whole_screw=everything)
    if refine > 1:
        steps = np.arange(refine) / refine
        nodes = np.append((nodes[:-1, None] + np.diff(nodes)[:, None] * steps[None, :]).ravel(), nodes[-1])
    fixed, prescribed, load = _nodal_supports_and_loads(scene, nodes)
    count = layout.z.size
    node = np.zeros((count, 2), dtype=np.int64)
    nodal = scene.ingredients.partition == "nodal"
    B = np.zeros((count, 2, 2, 6 if nodal else 12))
    for s in used:
        if nodal:
            node[:, s] = _nearest_nodes(nodes, stations[:, s])
            B[:, s] = flank_motion_matrix(parts, s, nodes[node[:, s]])
        else:
            node[:, s], m = beam_interpolation_matrices(stations[:, s], nodes, section)
            B[:, s] = flank_motion_matrix(parts, s, stations[:, s]) @ m
    for s in range(2):
        if not use[s]:
            node[:, s] = node[:, used[0]] if used else 0
    shaft = nodes, fixed, prescribed, load, node, B, section, scene.track.pitch_radius, scene.nut.position
    return Problem(
        *shaft, scene=scene, layout=layout, drawn=drawn, balls=balls, used_flanks=use, left_out_elements=left_out
    )


def _nearest_nodes(nodes: Array, stations: Array) -> NDArray[np.int64]:
    """Return for each axial position [m] the index of the nearest of the nodes, whose positions [m] are sorted."""
    if stations.size < 400:
        return np.asarray(np.abs(nodes[None, :] - stations[:, None]).argmin(axis=1))
    j = np.clip(np.searchsorted(nodes, stations), 1, nodes.size - 1)
    return np.where(stations - nodes[j - 1] < nodes[j] - stations, j - 1, j).astype(np.int64)


def _build_rigid_problem(parts: Parts, use: Mask, balls: Balls, section: BeamSection) -> Problem:
    """Return the static problem of a rigid screw, whose six motions are taken at the nut's centre.

    The supports are linear constraints on these motions. ``parts``: scene, dimensions with errors, ball positions, and
    shifts of the flanks' centres of curvature, as for `flank_motion_matrix`; ``use`` ``(4,)``: which flanks get contacts;
    ``balls``: result of `nominal_balls`; ``section``: cross-section of the screw.

    Raises
    ------
    ValueError
        If supports contradict each other.
    """
    scene, drawn, layout, _ = parts
    z0 = scene.nut.position
    arm = scene.track.pitch_radius
    scale = np.repeat([1.0, 1.0 / arm], 3)
    clash = find_support_contradiction(scene)
    if clash is not None:
        raise ValueError(clash.message(scene))
    a, values, _ = support_constraints(scene)
    load = np.zeros(6)
    for x in scene.loads:
        load += rigid_motion_transfer_matrix(x.at - z0).T @ np.concatenate([x.force, x.moment])
    held = 0
    basis = np.eye(6)
    lift = np.zeros(6)
    if values.size:
        sv, vt = right_singular_vectors(a)
        held = int(np.sum(sv > 1e-9 * sv[0]))
        basis = np.concatenate([vt[held:], vt[:held]]).T
        lift[:] = np.linalg.lstsq(a, values, rcond=None)[0]
    to_motion = scale[:, None] * basis / scale[None, :]
    count = layout.z.size
    B = np.stack([flank_motion_matrix(parts, s, np.full(count, z0)) @ to_motion for s in range(2)], axis=1)
    fixed = np.arange(6)[None] >= 6 - held
    prescribed, work = np.linalg.solve(to_motion, scale * lift)[None, :], (to_motion.T @ load)[None, :]
    shaft = np.array([z0]), fixed, prescribed, work, np.zeros((count, 2), dtype=np.int64), B, section, arm, z0
    return Problem(
        *shaft, scene=scene, layout=layout, drawn=drawn, balls=balls, used_flanks=use, rigid_motion_basis=to_motion
    )


#: Difference between a support's constraint and the best combination of earlier constraints, relative to its norm, above
#: which it counts as independent of them.
INDEPENDENT = 1e-9
#: Difference of two prescribed values, relative to the largest prescribed value, below which they count as equal.
AGREES = 1e-9


@dataclass(frozen=True)
class PrescribedMotion:
    """One degree of freedom of the screw that a support fixes, with its prescribed value."""

    #: Number of the support in the scene, from 0.
    support_index: int
    #: Name of the degree of freedom: displacement "ux", "uy", "uz" or rotation "rx", "ry", "rz".
    freedom: str
    #: Prescribed value [m or rad].
    value: float


@dataclass(frozen=True)
class SupportContradiction:
    """Contradiction between supports of a rigid screw: a prescribed value differs from what the other supports imply."""

    #: Degree of freedom with the prescribed value that contradicts the other supports.
    contradicted: PrescribedMotion
    #: Value of this degree of freedom that the other supports imply [m or rad].
    implied: float
    #: Fixed degrees of freedom of the other supports, from which the value ``implied`` follows.
    implied_by: tuple[PrescribedMotion, ...]

    def message(self, scene: Scene) -> str:
        """Return one sentence for the user on the contradiction, with the supports' axial positions in mm.

        ``scene``: the screw with its supports.
        """
        first, *others = (
            f"{x.freedom} at {1e3 * scene.supports[x.support_index].at:g} mm (supports[{x.support_index}])"
            for x in (self.contradicted, *self.implied_by)
        )
        implied = replace(self.contradicted, value=self.implied)
        return (
            f"the supports contradict each other on a rigid screw: {first} is "
            f"{describe_prescribed_value(self.contradicted)}, but {', '.join(others)} "
            f"make it {describe_prescribed_value(implied)}"
        )


def describe_prescribed_value(held: PrescribedMotion) -> str:
    """Return the prescribed value of a fixed degree of freedom as text: um for a displacement, mrad for a rotation.

    Parameters
    ----------
    held
        Fixed degree of freedom with its value.
    """
    return f"{1e6 * held.value:.6g} um" if held.freedom in FREEDOMS[:3] else f"{1e3 * held.value:.6g} mrad"


def support_constraints(scene: Scene) -> tuple[Array, Array, list[PrescribedMotion]]:
    """Return the supports of a rigid screw as k linear constraints on its six motions, taken at the nut's centre.

    ``scene``: screw with supports, which fix k degrees of freedom.

    Returns
    -------
    tuple[Array, Array, list[PrescribedMotion]]
        Matrix ``(k, 6)`` and right-hand side ``(k,)`` [m] of the constraints, and the k fixed degrees of freedom. Rotations
        are multiplied by the pitch radius.
    """
    arm = scene.track.pitch_radius
    scale = np.repeat([1.0, 1.0 / arm], 3)
    held = [PrescribedMotion(i, name, value) for i, s in enumerate(scene.supports) for name, value in s.fixed]
    rows, values = np.zeros((len(held), 6)), np.zeros(len(held))
    for j, x in enumerate(held):
        k = FREEDOMS.index(x.freedom)
        reach = scene.supports[x.support_index].at - scene.nut.position
        rows[j] = rigid_motion_transfer_matrix(reach)[k] * scale / scale[k]
        values[j] = x.value / scale[k]
    return rows, values, held


def find_support_contradiction(scene: Scene) -> SupportContradiction | None:
    """Return the first prescribed displacement of a rigid screw that contradicts earlier supports; None without one.

    Parameters
    ----------
    scene
        Screw with supports.

    Returns
    -------
    SupportContradiction | None
        None if all supports agree.
    """
    rows, values, held = support_constraints(scene)
    size = float(np.abs(values).max(initial=0.0))
    if size == 0.0:
        return None
    kept = [0]
    for j in range(1, len(held)):
        share = np.linalg.lstsq(rows[kept].T, rows[j], rcond=None)[0]
        new = rows[j] - share @ rows[kept]
        if float(np.linalg.norm(new)) > INDEPENDENT * float(np.linalg.norm(rows[j])):
            kept.append(j)
            continue
        implied = float(share @ values[kept])
        if abs(implied - values[j]) > AGREES * size:
            by = tuple(held[k] for k, x in zip(kept, share, strict=True) if abs(x) > INDEPENDENT)
            arm = 1.0 if held[j].freedom in FREEDOMS[:3] else 1.0 / scene.track.pitch_radius
            return SupportContradiction(held[j], implied * arm, by)
    return None
