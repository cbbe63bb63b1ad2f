"""Choice of the flanks that the static model leaves out because they cannot touch a ball.

The result tells the user which flanks and parts of the shaft were left out, with the reasons.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.contact_law import lengths
from rollbench.lowfi.statics.held import UnresistedMotions
from rollbench.lowfi.statics.problem import Problem, place_balls
from rollbench.lowfi.statics.rolling_elements import Balls, ball_equilibrium
from rollbench.lowfi.statics.shape import beam_interpolation_matrices
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.one_arc import flanks_of_single_arc_contacts, has_single_arc_grooves
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.meshes.section import MERGE, contact_force_positions

#: Share of the largest contact force up to which a ball between all four flanks does not touch them.
LEAST = 1e-9


def flanks_of_scene(scene: Scene) -> Mask:
    """Return which of the four flanks (screw left, screw right, nut left, nut right) a scene has, as booleans ``(4,)``.

    Gothic grooves have all four; a groove of a single arc has one flank on the screw and one on the nut.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    return np.isin(np.arange(4), flanks_of_single_arc_contacts(scene) or range(4))


def choose_flanks(scene: Scene, drawn: GeometryWithErrors) -> Mask:
    """Return which of the flanks SL, SR, NL, NR (screw left, ..., nut right) get contacts in the equations ``(4,)``.

    A diagonal pair of flanks is left out if no ball has interference with it and the axial load opens it. This is a guess:
    every ball of the solution is tested against all four flanks. If a ball touches the pair, the problem is solved
    again with it. Since the energy is convex, a pair that no ball touches in the solution would not change it.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    drawn
        Dimensions of the parts with their manufacturing errors.
    """
    use = flanks_of_scene(scene)
    force = sum(load.force[2] for load in scene.loads)
    lateral = sum(hypot(*load.force[:2]) for load in scene.loads)
    moment = sum(hypot(*load.moment[:2]) for load in scene.loads)
    bent = any(value != 0.0 for s in scene.supports for name, value in s.fixed if name != "uz")
    across = lateral > 0.5 * abs(force) or moment > 0.5 * abs(force) * scene.track.pitch_radius
    if not np.all(use) or force == 0.0 or bent or across:
        return use
    idle = (1, 2) if force > 0.0 else (0, 3)
    closure = place_balls(scene, drawn).interference
    if float(closure[:, min(idle)].max()) <= 0.0:
        use[list(idle)] = False
    return use


def screw_flank_motions(problem: Problem, motion: Array) -> Array:
    """Return the motions of the screw's two flanks at every ball ``(..., N, 2, 2)`` [m], also of flanks without contacts.

    The two components lie in the ball's section plane.

    Parameters
    ----------
    problem
        Static problem of N balls and n nodes.
    motion
        Motions of the nodes ``(..., n, 6)`` [m, rad].
    """
    layout, flat = problem.layout, motion.reshape(*motion.shape[:-2], -1)
    m = problem.B.shape[3]
    out = np.zeros((*motion.shape[:-2], layout.z.size, 2, 2))
    for s in range(2):
        if problem.used_flanks[s] or problem.rigid_motion_basis is not None:
            picks = 6 * problem.first_nodes[:, s, None] + np.arange(m)[None, :]
            out[..., s, :] = (problem.B[:, s] @ flat[..., picks, None])[..., 0]
            continue
        stations = contact_force_positions(problem.scene, layout)[:, s]
        j, shapes = beam_interpolation_matrices(stations, problem.nodes, problem.section)
        around = np.concatenate([motion[..., j, :], motion[..., j + 1, :]], axis=-1)
        moved_at = (shapes @ around[..., None])[..., 0]
        out[..., s, :] = groove_arc_motions_in_section_planes(
            layout, problem.drawn.groove_centres[:, s], stations, moved_at
        )
    return out


def groove_arc_motions_in_section_planes(layout: BallLayout, centre: Array, stations: Array, motions: Array) -> Array:
    """Return the motion of the screw's groove arc at each ball, radial and along the helix's binormal.

    It is the motion of the arc's centre, which moves rigidly with the shaft's cross-section.

    Parameters
    ----------
    layout
        Positions of the N balls.
    centre
        Centre of the groove arc in each ball's section plane ``(N, 2)`` [m], from the ball's centre.
    stations
        Axial position of the shaft's cross-section for each ball ``(N,)`` [m].
    motions
        Motion of this cross-section ``(..., N, 6)`` [m, rad].

    Returns
    -------
    Array
        ``(..., N, 2)`` [m].
    """
    r = layout.centre + centre[:, :1] * layout.radial + centre[:, 1:] * layout.binormal
    r[:, 2] -= stations
    u = motions[..., :3] + np.cross(motions[..., 3:], r)
    return np.stack([np.sum(u * layout.radial, axis=-1), np.sum(u * layout.binormal, axis=-1)], axis=-1)


def all_flank_motions_by_screw(problem: Problem, motion: Array) -> Array:
    """Return the motions of all four flanks at every ball ``(..., N, 4, 2)`` [m] by the screw's motion, with the nut fixed.

    Parameters
    ----------
    problem
        Static problem of N balls and n nodes.
    motion
        Motions of the nodes ``(..., n, 6)`` [m, rad].
    """
    moved = screw_flank_motions(problem, motion)
    return np.concatenate([moved, np.zeros_like(moved)], axis=-2)


def gaps_to_flanks(centres: Array, shift: Array, balls: Balls) -> Array:
    """Return the gap between each ball and each of its four groove arcs in k solutions ``(k, N, 4)`` [m].

    A negative gap is an interference of ball and groove.

    Parameters
    ----------
    centres
        Displacements of the ball centres in their section planes ``(k, N, 2)`` [m].
    shift
        Motions of the flanks ``(k, N, 4, 2)`` [m].
    balls
        Contacts before anything moves, with k as first axis (one for all solutions, or k).
    """
    moved = centres[:, :, None] - shift
    w = balls.to_ball + moved
    grown = (moved * (balls.to_ball + w)).sum(axis=-1) / (lengths(w) + balls.distance)
    return np.asarray(-balls.approach - grown)


def solutions_clear_of_left_out_flanks(
    centres: Array, shift: Array, balls: Balls, loads: Array, use: Mask, margin: float = 0.0
) -> NDArray[np.bool_]:
    """Return for each of k solutions whether all balls are clear of the flanks that were left out ``(k,)``.

    An unloaded ball, whose position is not determined, is clear if there is a position without contact: its present one, or
    the mean displacement of its flanks.

    Parameters
    ----------
    centres
        Displacements of the ball centres in their section planes ``(k, N, 2)`` [m].
    shift
        Motions of the flanks ``(k, N, 4, 2)`` [m].
    balls
        Contacts before anything moves, with k as first axis (one for all solutions, or k).
    loads
        Contact forces ``(k, N, 4)`` [N].
    use
        Which of the four flanks (screw left, screw right, nut left, nut right) have contacts in the equations ``(4,)``.
    margin
        Least gap [m] between a ball and a left-out flank at which the ball counts as clear of it.
    """
    left_out, loaded = np.flatnonzero(~use), loads.max(axis=2) > 0.0
    clearance = gaps_to_flanks(centres, shift, balls)
    gap = np.where(loaded, clearance[..., left_out].min(axis=2), clearance.min(axis=2))
    elsewhere = gaps_to_flanks(shift.mean(axis=2), shift, balls).min(axis=2)
    idle = ~loaded.all(axis=1)[:, None] & ~loaded
    gap = np.where(idle, np.maximum(gap, elsewhere), gap)
    return np.asarray((gap >= margin).all(axis=1))


def place_unloaded_balls_clear(problem: Problem, shift: Array, centres: Array, force: Array) -> Array:
    """Return displacements of the ball centres ``(N, 2)`` [m], where no unloaded ball overlaps a flank.

    The position of an unloaded ball is not determined. One that overlaps a flank without contacts in the equations gets the
    position that it finds between all four.

    Parameters
    ----------
    problem
        Static problem of N balls, whose flanks are circular arcs.
    shift
        Motions of the flanks ``(N, 4, 2)`` [m].
    centres
        Displacements of the ball centres in their section planes ``(N, 2)`` [m].
    force
        Contact forces ``(N, 4)`` [N].
    """
    if np.array_equal(problem.used_flanks, flanks_of_scene(problem.scene)):
        return centres
    gap = gaps_to_flanks(centres[None], shift[None], problem.balls)[0].min(axis=1)
    overlap = (force.max(axis=1) == 0.0) & (gap < 0.0)
    if not overlap.any():
        return centres
    found = _between_all_flanks(problem, shift, force)[0]
    return np.where(overlap[:, None], found, centres)


def _between_all_flanks(problem: Problem, shift: Array, force: Array) -> tuple[Array, Array]:
    """Return displacements ``(N, 2)`` [m] of balls in equilibrium with all four flanks, and their forces ``(N, 4)`` [N].

    ``shift``: motions of the flanks ``(N, 4, 2)`` [m]; ``force``: contact forces ``(N, 4)`` [N], of whose largest the
    forces that count as none are a fraction.
    """
    balls = replace(problem.balls, used=np.ones((1, len(shift), 4), dtype=bool)).one_by_one()
    nothing = np.full(len(shift), 0.1 * LEAST * float(force.max(initial=0.0)))
    x, contacts, _ = ball_equilibrium(balls, shift, nothing)
    return x[:, :2], contacts.force


def touched_flanks(problem: Problem, motion: Array, centres: Array, force: Array) -> Mask:
    """Return which of the four flanks touch a ball if all four are given contacts, as booleans ``(4,)``.

    The order is screw left, screw right, nut left, nut right. The balls find new positions, while the screw keeps the
    motion that was solved without the left-out flanks, and the nut is rigid.

    Parameters
    ----------
    problem
        Static problem of N balls and n nodes.
    motion
        Motions of the nodes ``(n, 6)`` [m, rad].
    centres
        Displacements of the ball centres in their section planes ``(N, 2)`` [m].
    force
        Contact forces ``(N, 4)`` [N].
    """
    if np.array_equal(problem.used_flanks, flanks_of_scene(problem.scene)):
        return np.asarray((force > 0.0).any(axis=0))
    shift = all_flank_motions_by_screw(problem, motion)
    if not problem.drawn.profile_coefficients.shape[1]:
        parts = centres[None], shift[None], problem.balls, force[None]
        if solutions_clear_of_left_out_flanks(*parts, problem.used_flanks)[0]:
            return np.asarray((force > 0.0).any(axis=0))
    found = _between_all_flanks(problem, shift, force)[1]
    return np.asarray((found > LEAST * float(force.max(initial=0.0))).any(axis=0))


def describe_left_out_parts(problem: Problem, mechanism: UnresistedMotions, *, everything: bool) -> tuple[str, ...]:
    """Return sentences for the result that name the parts which the model left out, with the reasons.

    Parameters
    ----------
    problem
        Static problem.
    mechanism
        Rigid motions of the screw that nothing resists, and the degrees of freedom ("pins") that the model fixes to prevent
        them.
    everything
        Whether the user asked for all flanks and all parts of the shaft to be modelled.
    """
    notes: list[str] = []
    idle = [name for name, used in zip(SIDES, problem.used_flanks, strict=True) if not used]
    if idle and has_single_arc_grooves(problem.scene):
        notes.append(f"flanks {' and '.join(idle)}: each groove is a single arc, which the other two flanks represent")
    elif idle:
        notes.append(
            f"flanks {' and '.join(idle)}: no ball has interference between them, and the axial load opens them; "
            "at the solution every ball was tested against all four flanks, and none touches these"
        )
    if problem.left_out_elements:
        notes.append(
            f"{problem.left_out_elements} beam element(s) beyond the outermost support, load or contact: they carry no load"
        )
    elif not everything and problem.nodes.size > 1 and problem.nodes[0] > MERGE:
        notes.append("shaft before the first support, load or contact: it carries no load")
    if mechanism.no_torsion:
        notes.append("torsion: without lead no contact force twists the shaft, and no moment about its axis is applied")
    notes.extend(
        f"{FREEDOMS[k] + ' of the first node' if problem.rigid_motion_basis is None else 'the screw'} is fixed at zero: "
        f"{mechanism.description} is neither driven nor resisted"
        for k in mechanism.pins
        if not (k == 5 and mechanism.no_torsion)
    )
    if problem.drawn.profile_coefficients.shape[1] == 0:
        notes.append("groove profile errors: the scene has none, flanks are exact circular arcs")
    if not everything and not np.any(problem.drawn.groove_centre_derivatives):
        notes.append("pitch and roundness errors: the scene has none")
    return tuple(notes)
