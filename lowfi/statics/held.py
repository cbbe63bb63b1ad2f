"""Rigid motions of a screw that nothing resists, and a proof whether its contacts can carry a load at all.

Motions that neither a support nor a contact resists are determined before the equilibrium is solved. Whether the contacts
can carry a load is decided by a linear program for compressive contact forces.

By the theorem of the alternative (Farkas) exactly one of two statements holds. Either compressive forces at the nominal
contacts and reactions of the supports balance the load. Or a rigid motion of the screw, with some motion of the balls,
opens every contact or leaves it unchanged while the load does work. Only the second proves that nothing holds the screw.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollbench.lowfi.statics.contact_law import SIGNS
from rollbench.lowfi.statics.problem import Problem, point_motion_matrix
from rollbench.lowfi.statics.result import Status
from rollbench.lowfi.statics.shape import independent_columns, null_space_of_constraints, rigid_motion_transfer_matrix
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import nominal_contact_points
from rollbench.meshes.parts import FREEDOMS


@dataclass(frozen=True)
class UnresistedMotions:
    """Rigid motions of screw, or of shaft and housings, that no support, spring or contact resists, and pins against them.

    A pin is a degree of freedom that the model fixes although no support does.
    """

    #: Whether the loads do work on an unresisted motion, so that there is no equilibrium.
    is_driven_by_loads: bool
    #: Text for the user that describes the unresisted motion; empty if there is none.
    description: str
    #: Numbers of the degrees of freedom that the model fixes against these motions, six for each beam node, then for each
    #: moving housing; for a rigid screw, numbers of its coordinates (columns of `Problem.rigid_motion_basis`).
    pins: tuple[int, ...] = ()
    #: Whether nothing can twist the shaft: its grooves have no lead, and no moment about the axis acts.
    no_torsion: bool = False
    #: Numbers (0 to 5) of other degrees of freedom that could be fixed instead of those in ``pins``; empty if there are
    #: none.
    alternative_pins: tuple[int, ...] = ()


def _motions_free_of_supports(problem: Problem) -> tuple[Array, Array, Array]:
    """Return the k rigid motions of the screw that its supports leave free, at the first node and at the balls' centres.

    The screw's motion is taken at each ball's centre, where a screw motion along the helix is exactly free. At the contact
    points, the planar sections of the model would seem to resist it. This artefact is proportional to the sine of the lead
    angle and to the difference in radius between the ball's centre and the contact point.

    Returns
    -------
    tuple[Array, Array, Array]
        Motions of the first node ``(6, k)``; motions of the screw at the N ball centres in their section planes
        ``(2 N, k)``; work of the loads on the motions ``(k,)``.
    """
    arm = problem.scene.track.pitch_radius
    scale = np.repeat([1.0, 1.0 / arm], 3)
    z = problem.nodes
    transport = rigid_motion_transfer_matrix(z - z[0])
    if problem.rigid_motion_basis is not None:
        motions = problem.rigid_motion_basis[:, ~problem.fixed[0]]
        work = problem.load[0, ~problem.fixed[0]]
    else:
        motions = scale[:, None] * null_space_of_constraints(transport[problem.fixed] * scale).T
        work = np.einsum("nij,ni->j", transport, problem.load) @ motions
    layout = problem.layout
    r = layout.centre - np.array([0.0, 0.0, z[0]])
    rows = point_motion_matrix(layout, r)
    return motions, (rows @ motions).reshape(2 * len(r), motions.shape[1]), work


def loads_do_work_on(work: Array, load: Array, arm: float) -> bool:
    """Return whether the loads do work on any of several rigid motions, apart from round-off.

    Parameters
    ----------
    work
        Work of the loads on each motion, per metre of amplitude [N].
    load
        Loads ``(n, 6)`` [N, N m].
    arm
        Length [m] by which moments are divided where they are compared with forces.
    """
    total = float(np.abs(load[:, :3]).sum() + np.abs(load[:, 3:]).sum() / arm)
    return float(np.abs(work).max()) > 1e-9 * total > 0.0


def find_unresisted_motions(problem: Problem) -> UnresistedMotions:
    """Return the rigid motions of the screw that no contact and no support resists, and whether the loads drive them.

    Parameters
    ----------
    problem
        Arrays of the static problem.
    """
    track = problem.scene.track
    twist = float(np.abs(problem.load[:, 5]).sum()) if problem.rigid_motion_basis is None else 0.0
    no_torsion = track.lead == 0.0 and twist == 0.0 and problem.nodes.size > 1
    motions, flanks, work = _motions_free_of_supports(problem)
    null = null_space_of_constraints(flanks) if motions.shape[1] else np.zeros((0, 0))
    if null.shape[0] == 0:
        return UnresistedMotions(False, "", (), no_torsion)
    free = motions @ null.T
    seen = rigid_motion_transfer_matrix(problem.scene.nut.position - float(problem.nodes[0])) @ free
    text = _describe_free_motions(seen, track.lead, track.pitch_radius)
    if loads_do_work_on(null @ work, problem.load, track.pitch_radius):
        return UnresistedMotions(True, f"{text}: no support and no contact resists it, and the loads drive it")
    if problem.rigid_motion_basis is not None:  # coordinates: the columns of the basis that the supports leave free
        left = np.flatnonzero(~problem.fixed[0])
        return UnresistedMotions(False, text, tuple(int(left[k]) for k in independent_columns(null)), no_torsion)
    pins = tuple(independent_columns(free.T))
    return UnresistedMotions(False, text, pins, no_torsion, _alternative_pins(free, pins, track.pitch_radius))


def _alternative_pins(free: Array, pins: tuple[int, ...], arm: float) -> tuple[int, ...]:
    """Return other degrees of freedom than ``pins`` that prevent all free motions ``(6, k)``; empty if there are none.

    ``arm``: length [m] by which rotations are multiplied where they are compared with displacements.
    """
    scaled = free * np.repeat([1.0, arm], 3)[:, None]
    rest = [k for k in range(6) if k not in pins]
    others = tuple(rest[k] for k in independent_columns(scaled[rest].T))
    sizes = np.linalg.svd(scaled[list(others)], compute_uv=False)
    return others if len(others) == len(pins) and sizes[-1] > 1e-6 * np.abs(scaled).max() else ()


def _describe_free_motions(free: Array, lead: float, arm: float) -> str:
    """Return a description in words of motions of the screw that nothing resists, such as "screw motion along the helix".

    ``free`` ``(6, k)``: the motions of the screw's section at the nut's centre; ``lead``: lead of the helix [m], 0 for a
    bearing; ``arm``: length [m] by which rotations are multiplied where they are compared with displacements.
    """
    scaled = np.abs(free * np.repeat([1.0, arm], 3)[:, None]).max(axis=1)
    if free.shape[1] == 1 and scaled[:2].max() + scaled[3:5].max() < 1e-6 * scaled.max():
        return "screw motion along the helix" if lead > 0.0 else "rotation about the screw's axis"
    parts = [name for name, size in zip(FREEDOMS, scaled, strict=True) if size > 1e-6 * scaled.max()]
    return "rigid motion in " + ", ".join(parts) + " at the nut's centre"


#: Least work of the loads on a motion that opens all contacts, relative to their largest work on a unit motion, that counts
#: as proof that the contacts cannot carry the loads.
PROVEN = 1e-7


def find_opening_motion(problem: Problem) -> Array | None:
    """Find a rigid motion of the screw that opens all contacts while the load does work, by a linear program.

    Contacts are taken at their nominal angles.

    Returns
    -------
    Array | None
        Motion ``(6,)`` [m] at the nut's centre, rotations multiplied by the pitch radius. None if compressive contact
        forces can balance the load.

    Raises
    ------
    ArithmeticError
        If the linear program fails.
    """
    scene, layout = problem.scene, problem.layout
    arm, z0 = scene.track.pitch_radius, scene.nut.position
    scale = np.repeat([1.0, 1.0 / arm], 3)
    N, point = layout.z.size, nominal_contact_points(scene)
    flank = np.zeros((4, N, 2, 6))
    for s in range(2):
        x = layout.centre + point[s, 0] * layout.radial + point[s, 1] * layout.binormal - np.array([0.0, 0.0, z0])
        flank[s] = point_motion_matrix(layout, x) * scale
    sides = [approach_change_by_motions(s, scene.track.contact_angle, flank[s], 0, N) for s in range(4)]
    rows = np.stack(sides, axis=1).reshape(4 * N, -1)
    work = np.zeros(6)
    held: list[Array] = []
    for load in scene.loads:
        work += scale * (rigid_motion_transfer_matrix(load.at - z0).T @ np.concatenate([load.force, load.moment]))
    for support in scene.supports:
        transport = rigid_motion_transfer_matrix(support.at - z0) * scale
        held += [transport[FREEDOMS.index(name)] for name, _ in support.fixed]
    return None if not work.any() else find_opening_by_linear_program(work, rows, np.array(held).reshape(-1, 6))


def approach_change_by_motions(side: int, angle: float, flank_motions: Array, first_ball: int, ball_count: int) -> Array:
    """Return the change of each contact's approach on one flank of N balls, per unit motion of bodies and ball centres.

    Parameters
    ----------
    side
        Number of the flank in the order screw left, screw right, nut left, nut right.
    angle
        Contact angle [rad].
    flank_motions
        Motions of the flank in each ball's section plane (radial, and along the helix's binormal), per unit of k motions of
        the bodies ``(N, 2, k)``.
    first_ball
        Index of the first of the N balls among all balls of the assembly.
    ball_count
        Number of all balls of the assembly.

    Returns
    -------
    Array
        ``(N, k + 2 ball_count)``: columns for the k motions of the bodies, then for both coordinates of each ball's centre.
    """
    N, direction = len(flank_motions), SIGNS[side] * np.array([np.cos(angle), np.sin(angle)])
    centres = np.zeros((N, ball_count, 2))
    centres[np.arange(N), first_ball + np.arange(N)] = direction
    return np.concatenate([-np.einsum("a,nak->nk", direction, flank_motions), centres.reshape(N, -1)], axis=1)


def find_opening_by_linear_program(work: Array, approach_rows: Any, fixed_motion_rows: Array) -> Array | None:
    """Find, by a linear program, a motion on which the loads do work while no contact is compressed.

    Degrees of freedom that supports fix do not move.

    Parameters
    ----------
    work
        Work of the loads on unit motions of the bodies ``(k,)``.
    approach_rows
        Change of every contact's approach per unit motion of the bodies (first k columns) and of the ball centres (further
        columns): a matrix, dense or sparse, with one row for each contact.
    fixed_motion_rows
        Motions of the h fixed degrees of freedom per unit motion of the bodies ``(h, k)``.

    Returns
    -------
    Array | None
        Amplitudes of the k motions, each of magnitude at most one. None if compressive contact forces can balance the load.

    Raises
    ------
    ArithmeticError
        If the linear program fails.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, hstack

    k, (contacts, wide), h = work.size, approach_rows.shape, len(fixed_motion_rows)
    centres = wide - k
    found = linprog(
        np.concatenate([-work / np.abs(work).max(), np.zeros(centres)]),
        A_ub=approach_rows,
        b_ub=np.zeros(contacts),
        A_eq=hstack([csr_array(fixed_motion_rows), csr_array((h, centres))]) if h else None,
        b_eq=np.zeros(h) if h else None,
        bounds=[(-1.0, 1.0)] * k + [(None, None)] * centres,
    )
    if found.status != 0:
        raise ArithmeticError(f"the linear program for the contact forces failed: {found.message}")
    return None if -found.fun <= PROVEN else np.asarray(found.x[:k])


def status_of_runaway_body(find_motion: Callable[[], Array | None], body: str, describe: Callable[[Array], str]) -> Status:
    """Return the status of a solve in which a body moved without limit in the Newton iteration.

    The status is "not held" only if a linear program proves that the contacts cannot carry the load; otherwise it is "not
    converged".

    Parameters
    ----------
    find_motion
        Function that returns a motion which opens the body's contacts, or None if there is none.
    body
        Name of the body for the message.
    describe
        Function that returns the message for such a motion.
    """
    try:
        opened = find_motion()
    except ArithmeticError as error:
        why = f"{body} moved without limit, and it is not known whether its contacts can carry the load: {error}"
        return Status("not converged", why)
    if opened is not None:
        return Status("not held", describe(opened))
    why = f"{body} moved without limit, although compressive contact forces can balance the loads (linear program)"
    return Status("not converged", why)


def describe_motion(motion: Array) -> str:
    """Return the components of a rigid motion ``(6,)`` as text in order of size, for example "uz +1, rx -0.2"."""
    order = np.argsort(-np.abs(motion))
    named = [f"{FREEDOMS[k]} {motion[k] / np.abs(motion).max():+.2g}" for k in order if abs(motion[k]) > 1e-3]
    return ", ".join(named)
