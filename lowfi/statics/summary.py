"""Conversion of the solver's arrays into the static result: contact points, equilibrium check, reactions, centreline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.statics.problem import ContactState, Problem, SolvedState
from rollbench.lowfi.statics.result import Equilibrium, SolverReport, StaticResult, Status
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.statics.shape import beam_interpolation_matrices, rigid_motion_transfer_matrix
from rollbench.lowfi.statics.validity import validity_warnings
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import FREEDOMS, Load, Scene, Support

#: Assumptions of every result of Lin's low-order model.
MODEL_ASSUMPTIONS = (
    "the nut is rigid and fixed, apart from the Hertzian contacts (Lin 2.3.1)",
    "sections of the screw stay plane and rigid; the shaft is a straight Timoshenko beam (Lin 2.18)",
    "each ball stays in the section plane of its nominal azimuth (Lin 2.3.2, remark 1)",
    "no friction, no cage, no contact between balls (Lin 2.1)",
    "displacements are small: directions and lever arms of the undeformed helix",
)


#: Axial distance [m] between the points at which the motion of the shaft's centreline is reported, besides the nodes.
STATION = 10e-3
#: Index of the assumption about the screw in `MODEL_ASSUMPTIONS`, and the sentence that replaces it for a rigid screw.
SCREW, RIGID_SCREW = 1, "the screw is rigid, apart from the Hertzian contacts"
#: Largest unbalanced force or moment on screw or ball, relative to the largest force or moment, that a converged solution
#: may have.
BALANCE = 1e-6
#: Force [N] or moment [N m] that is round-off in any scene: without loads, motions of round-off leave such forces in
#: contacts that just touch.
NO_FORCE = 1e-15
#: Assumptions of Lin's model that hold also for elastic screw, nut and balls.
ELASTIC_ASSUMPTIONS = MODEL_ASSUMPTIONS[2:]


def model_assumptions(scene: Scene) -> tuple[str, ...]:
    """Return the assumptions of Lin's model as sentences, for a scene with an elastic or a rigid screw."""
    if scene.ingredients.screw != "rigid":
        return MODEL_ASSUMPTIONS
    return (*MODEL_ASSUMPTIONS[:SCREW], RIGID_SCREW, *MODEL_ASSUMPTIONS[SCREW + 1 :])


def centreline_motions(problem: Problem, q: Array) -> tuple[Array, Array]:
    """Return k axial positions along the whole screw [m], and the motions of its cross-sections there ``(k, 6)`` [m, rad].

    Parameters
    ----------
    problem
        Static problem with n nodes.
    q
        Motions of the nodes ``(n, 6)`` [m, rad]; for a rigid screw the six coordinates of its motion with respect to the
        basis `Problem.rigid_motion_basis`.
    """
    stations = centreline_positions(problem.scene.screw.length, problem.nodes)
    if problem.rigid_motion_basis is not None:
        return stations, rigid_motion_transfer_matrix(stations - problem.nodes[0]) @ problem.rigid_motion_basis @ q.ravel()
    j, m = beam_interpolation_matrices(stations, problem.nodes, problem.section)
    of_nodes = q.reshape(-1, 6)
    return stations, np.asarray(np.einsum("kab,kb->ka", m, np.concatenate([of_nodes[j], of_nodes[j + 1]], axis=1)))


def centreline_positions(length: float, nodes: Array) -> Array:
    """Return the sorted axial positions [m] at which the centreline of a screw is reported: every 10 mm, and all nodes.

    Parameters
    ----------
    length
        Length of the screw [m].
    nodes
        Axial positions of the beam's nodes [m].
    """
    every = np.unique(np.concatenate([np.arange(0.0, length + 0.5 * STATION, STATION), nodes, [length]]))
    return every[every <= length]


def contact_points_and_force_directions(contacts: ContactState) -> tuple[Array, Array]:
    """Return the contact points on the undeformed flanks [m], and the unit vectors of the contact forces on the balls.

    ``contacts``: solution with N balls. Both arrays have the shape ``(N, 4, 3)``: balls, four flanks (screw left, screw
    right, nut left, nut right), and the coordinates x, y, z of the scene.
    """
    problem, normal = contacts.problem, contacts.normal
    layout = problem.layout
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    plane = problem.drawn.groove_radii[None, :, None] * normal
    if problem.drawn.profile_coefficients.shape[1]:
        w = -problem.drawn.groove_centres + contacts.ball_centres[:, None, :] - contacts.flank_motions
        distance = problem.drawn.ball_radii[:, None] - contact_approach(contacts.force, problem.C)
        plane = w + distance[..., None] * normal
    points = np.einsum("nsa,nak->nsk", plane + problem.drawn.groove_centres, axes) + layout.centre[:, None, :]
    return points, -np.einsum("nsa,nak->nsk", normal, axes)


def check_screw_equilibrium(solved: SolvedState, points: Array, on_ball: Array) -> Equilibrium:
    """Return the check of a screw's equilibrium: sums of forces and moments on it, and the largest net force on a ball.

    The screw is loaded by external loads, support reactions, contact forces at the contact points, and by pins: degrees of
    freedom that are fixed although no support fixes them.

    Parameters
    ----------
    solved
        Solution with N balls.
    points
        Contact points ``(N, 4, 3)`` [m].
    on_ball
        Unit vectors of the contact forces on the balls ``(N, 4, 3)``.
    """
    problem, force, nodal = solved.contacts.problem, solved.contacts.force, solved.reactions
    scene, pins = problem.scene, np.isin(np.arange(6), problem.pins)
    on_screw = -on_ball[:, :2] * force[:, :2, None]
    moments = np.cross(points[:, :2], on_screw)
    contact = np.concatenate([on_screw.sum(axis=(0, 1)), moments.sum(axis=(0, 1))])
    applied = resultant_of_loads(scene.loads)
    if problem.rigid_motion_basis is None:
        pinned = np.where(pins, nodal[0], 0.0)
        held = np.concatenate([[nodal[0] - pinned], nodal[1:]])
        reaction, pin = resultant_about_origin(problem.nodes, held), resultant_about_origin(problem.nodes[:1], pinned[None])
    else:  # the supports of a rigid screw carry the remaining load along the motions that they prevent
        t, z0 = problem.rigid_motion_basis, problem.nodes[:1]
        along = np.where(problem.fixed[0], t.T @ resultant_about_origin(-z0, (applied + contact)[None]), 0.0)
        each = (np.asarray(np.linalg.solve(t.T, np.where(taken, along, 0.0)))[None] for taken in (~pins, pins))
        reaction, pin = (resultant_about_origin(z0, -taken) for taken in each)
    size = max(
        *(float(np.abs(x[:3]).max()) for x in (applied, contact, reaction)),
        float(np.abs(nodal[:, 3:]).max()) / scene.track.pitch_radius,  # supports may load the screw by torsion alone
        float(force.max(initial=0.0)),
        solved.residual_force_scale,
    )
    sums = applied, reaction, contact, pin
    s, noise = problem.section, (0.0, 0.0)
    if problem.rigid_motion_basis is None:
        noise = round_off_forces(np.diff(problem.nodes), np.array([[s.EA, s.EI, s.GJ, s.kGA]]), solved.nodal_motions)
    net = magnitudes_of_net_ball_forces(force, solved.contacts.normal)
    return check_equilibrium(sums, size, scene.track.pitch_radius, noise, net)


def support_reactions(solved: SolvedState, reaction: Array) -> Array:
    """Return force and moment of every support on the screw, at the support's axial position ``(s, 6)`` [N, N m].

    If the supports of a rigid screw are statically indeterminate, the reactions of least norm are returned.

    Parameters
    ----------
    solved
        Solution.
    reaction
        Sum of force and moment of all supports about the origin ``(6,)`` [N, N m].
    """
    problem = solved.contacts.problem
    supports = problem.scene.supports
    if problem.rigid_motion_basis is None:
        return nodal_reactions(problem.nodes, supports, solved.reactions)
    held = [(i, FREEDOMS.index(name)) for i, s in enumerate(supports) for name, _ in s.fixed]
    unit = np.array([rigid_motion_transfer_matrix(supports[i].at)[k] for i, k in held]).reshape(-1, 6)
    out = np.zeros((len(supports), 6))
    for (i, k), size in zip(held, np.linalg.lstsq(unit.T, reaction, rcond=None)[0], strict=True):
        out[i, k] = size
    return out


def nodal_reactions(nodes: Array, supports: Sequence[Support], node_reactions: Array) -> Array:
    """Return force and moment of every support on the shaft ``(s, 6)`` [N, N m] from the reactions at the beam's nodes.

    Parameters
    ----------
    nodes
        Axial positions of the nodes ``(n,)`` [m].
    supports
        Supports with their fixed degrees of freedom.
    node_reactions
        Reactions at the nodes ``(n, 6)`` [N, N m].
    """
    out = np.zeros((len(supports), 6))
    for i, support in enumerate(supports):
        freedoms = [FREEDOMS.index(name) for name, _ in support.fixed]
        out[i, freedoms] = node_reactions[int(np.abs(nodes - support.at).argmin()), freedoms]
    return out


def resultant_about_origin(stations: Array, wrenches: Array) -> Array:
    """Return the resultant force and moment about the origin ``(6,)`` [N, N m] of forces and moments at points of the axis.

    Parameters
    ----------
    stations
        Axial positions of the points, ``(n,)`` [m].
    wrenches
        Forces and moments at the points, ``(n, 6)`` [N, N m].
    """
    return np.asarray(np.einsum("nij,ni->j", rigid_motion_transfer_matrix(stations), wrenches))


def resultant_of_loads(loads: Sequence[Load]) -> Array:
    """Return the resultant force and moment about the origin ``(6,)`` [N, N m] of external loads.

    Parameters
    ----------
    loads
        External loads of a scene, each at a point of the screw's axis.
    """
    wrenches = np.array([(*x.force, *x.moment) for x in loads]).reshape(-1, 6)
    return resultant_about_origin(np.array([x.at for x in loads]), wrenches)


def magnitudes_of_net_ball_forces(force: Array, normal: Array) -> Array:
    """Return the magnitude of the resultant contact force on each ball ``(N,)`` [N], which is zero in equilibrium.

    Parameters
    ----------
    force
        Contact forces of N balls on the four flanks ``(N, 4)`` [N].
    normal
        Unit normals of these contacts ``(N, 4, 2)``, in the section plane of each ball: radial, and along the helix's
        binormal.
    """
    return np.asarray(np.linalg.norm((force[..., None] * normal).sum(axis=1), axis=1))


def check_equilibrium(
    sums: Sequence[Array], largest: float, arm: float, noise: tuple[float, float], net: Array
) -> Equilibrium:
    """Return the check of equilibrium of a body: sums of forces and moments, relative to the largest force and moment.

    Parameters
    ----------
    sums
        Force and moment about the origin ``(6,)`` [N, N m] of external loads, support reactions, contact forces and pins,
        in this order. Pins are degrees of freedom that the model fixes although no support does.
    largest
        Largest force of the solution [N].
    arm
        Length [m]; ``largest`` times this length counts as the largest moment, unless a moment in ``sums`` is larger.
    noise
        Force [N] and moment [N m] that rounding errors leave; the magnitudes of the sums are reduced by them. Either counts
        for the other, too, at the length ``arm``.
    net
        Magnitude of the resultant force on each ball ``(N,)`` [N].
    """
    applied, reaction, contact, pin = sums
    size_m = max(max(float(np.abs(x[3:]).max()) for x in (applied, reaction, contact)), largest * arm)
    total, left_over = np.abs(applied + reaction + contact + pin), max(noise[0], noise[1] / arm)
    df, dm = np.maximum(total[:3] - left_over, 0.0), np.maximum(total[3:] - left_over * arm, 0.0)
    worst = int(net.argmax()) if net.size else -1
    sides = applied[:3], applied[3:], reaction[:3], reaction[3:], contact[:3], contact[3:]
    felt, turned = largest > NO_FORCE, size_m > NO_FORCE
    left = float(df.max()) / largest if felt else 0.0, float(dm.max()) / size_m if turned else 0.0
    pins = float(np.abs(pin[:3]).max()), float(np.abs(pin[3:]).max())
    pin_share = max(pins[0] / largest, pins[1] / size_m) if largest else 0.0
    on_ball = float(net[worst]) / largest if felt and net.size else 0.0
    return Equilibrium(*sides, *left, pin[:3], pin[3:], pin_share, on_ball, worst + 1)


def round_off_forces(lengths: Array, sections: Array, motion: Array) -> tuple[float, float]:
    """Return the force [N] and moment [N m] that rounding errors of the node motions cause in a beam's stiffest elements.

    Parameters
    ----------
    lengths
        Lengths of the elements ``(e,)`` [m].
    sections
        EA [N], EI [N m^2], GJ [N m^2], kGA [N] of the elements ``(e, 4)`` or ``(1, 4)``.
    motion
        Motions of the nodes ``(n, 6)`` [m, rad].
    """
    if not lengths.size:
        return 0.0, 0.0
    EA, EI, GJ, kGA = (float((column / lengths).max()) for column in sections.T)
    last = np.finfo(float).eps * np.abs(motion.reshape(-1, 6)).max(axis=0)
    bent = float(last[3:5].max())
    force = max(EA * last[2], kGA * last[:2].max(), float(sections[:, 3].max()) * bent)
    return float(force), float(max(EI * bent, GJ * last[5]))


def status_after_equilibrium_check(
    status: Status, balance: Equilibrium, nominal_arms: bool, body: str = "the screw", ball: str = ""
) -> Status:
    """Return the status of a solution after the check of equilibrium: "not converged" if a body or ball is out of balance.

    Parameters
    ----------
    status
        Status that the solver reported.
    balance
        Sums of forces and moments.
    nominal_arms
        Whether the model's lever arms end at the nominal contact points, so that moments about the true points do not
        balance and only the balls are checked.
    body
        Name of the body for the message.
    ball
        Name, for the message, of the ball with the largest net force; if empty, the message gives the ball's number.
    """
    if status != "converged" or (balance.ball_residual if nominal_arms else balance.largest) <= BALANCE:
        return status
    if balance.ball_residual == balance.largest:
        size = f"{balance.ball_residual:.1e} of the largest force"
        return Status("not converged", f"{ball or f'ball {balance.worst_ball}'} is out of balance by {size}")
    return Status("not converged", f"{body} is out of balance by {balance.largest:.1e} of the largest force or moment")


def add_reason_not_unique(status: Status, warnings: Sequence[ResultWarning]) -> Status:
    """Return the status, with the reason added if the solver did not converge because several contact patterns exist.

    Flanks with profile errors can touch a ball at several places. Warnings of the kind "profile" report this; their texts
    become part of the reason. Without such ``warnings``, ``status`` is returned unchanged.
    """
    places = [w for w in warnings if w.kind == "profile"]
    if status.kind != "not converged" or not places:
        return status
    return Status("not converged", "; ".join((status.reason, *places)), "not unique")


def contact_result(
    contacts: ContactState, z: Array, motion: Array, report: SolverReport, *, arc_on_both_sides: bool = False
) -> StaticResult:
    """Return the static result of one nut or bearing with all contacts, still without model name and equilibrium check.

    Parameters
    ----------
    contacts
        Contacts of the nut or bearing in the solution.
    z
        Axial positions of the shaft's centreline ``(k,)`` [m].
    motion
        Motions of the shaft at these positions ``(k, 6)`` [m, rad].
    report
        Effort and accuracy of the solve.
    arc_on_both_sides
        Whether each groove is one arc that extends to both sides of its bottom, as in a deep groove bearing. Contact angles
        are then checked by their magnitude.
    """
    problem, force = contacts.problem, contacts.force
    raw = contact_angles(contacts.normal)
    points, on_ball = contact_points_and_force_directions(contacts)
    return StaticResult(
        model="",
        status=Status("converged"),
        azimuth=problem.layout.azimuth,
        z=problem.layout.z,
        load=force,
        contact_angle=np.where(force > 0.0, raw, np.nan),
        contact_point=points,
        force_direction=on_ball,
        centre_shift=contacts.ball_centres,
        hertz_C=problem.C.copy(),
        centreline_z=z,
        centreline=motion,
        solver=report,
        warnings=validity_warnings(contacts, np.abs(raw) if arc_on_both_sides else raw, z, motion),
    )


def assemble_result(
    solved: SolvedState,
    model: str,
    status: Status,
    report: SolverReport,
    left_out: tuple[str, ...],
    assumptions: tuple[str, ...],
    *,
    has_own_lever_arms: bool = False,
) -> StaticResult:
    """Return the complete result of a solve: contacts, reactions, equilibrium check, status and assumptions.

    Parameters
    ----------
    solved
        Solution.
    model
        Name of the model.
    status
        Status that the solver reported.
    report
        Effort and accuracy of the solve.
    left_out
        Effects that the model neglects, as sentences.
    assumptions
        Assumptions of the model, as sentences.
    has_own_lever_arms
        Whether the model's lever arms and force directions differ from those of the true contacts, so that forces at the
        true contacts do not balance. The equilibrium check then does not change the status.
    """
    problem = solved.contacts.problem
    result = contact_result(solved.contacts, *centreline_motions(problem, solved.nodal_motions), report)
    balance = check_screw_equilibrium(solved, result.contact_point, result.force_direction)
    if not has_own_lever_arms:
        status = status_after_equilibrium_check(status, balance, problem.scene.ingredients.arm == "nominal")
    status = add_reason_not_unique(status, result.warnings)
    assumed = (*problem.scene.assumed, *assumptions)
    reactions = support_reactions(solved, np.concatenate([balance.reaction_force, balance.reaction_moment]))
    result = replace(result, model=model, status=status, equilibrium=balance, reactions=reactions)
    return replace(result, assumed=assumed, left_out=left_out)


def failed_result(problem: Problem, model: str, status: Status, seconds: float) -> StaticResult:
    """Return the result of a scene without equilibrium: its status gives the reason, and all loads are nan.

    Parameters
    ----------
    problem
        Static problem.
    model
        Name of the model.
    status
        Status, which gives the reason why there is no equilibrium.
    seconds
        Computing time [s].
    """
    report = SolverReport(0, 0, float("nan"), seconds, problem.unknowns, problem.nodes.size - 1, "none")
    assumed = (*problem.scene.assumed, *model_assumptions(problem.scene))
    n, layout = problem.layout.z.size, problem.layout
    shapes = {"load": (4,), "contact_angle": (4,), "contact_point": (4, 3), "force_direction": (4, 3), "centre_shift": (2,)}
    unknown: dict[str, Any] = {name: np.full((n, *shape), np.nan) for name, shape in shapes.items()}
    return StaticResult(
        model=model,
        status=status,
        azimuth=layout.azimuth,
        z=layout.z,
        hertz_C=problem.C.copy(),
        solver=report,
        assumed=assumed,
        **unknown,
    )
