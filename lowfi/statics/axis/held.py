"""Rigid motions of shaft and housings that nothing resists, and a proof whether contacts can carry an assembly's loads.

Rigid motions without resistance are determined before the equilibrium is solved. Whether the contacts can carry the loads
is decided by a linear program for compressive contact forces.

As for a single nut or bearing (`lowfi.statics.held`), exactly one of two statements holds. Either compressive forces at the
nominal contacts of balls and rollers balance the loads, together with supports and springs. Or a rigid motion of shaft and
housings opens every contact, or leaves it unchanged, while the loads do work. Only the second proves that the assembly is
not restrained.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from rollbench.lowfi.statics import held
from rollbench.lowfi.statics.axis.structure import restraints_on_rigid_motions, rigid_motions_of_shaft_and_housings
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet
from rollbench.lowfi.statics.held import UnresistedMotions
from rollbench.lowfi.statics.problem import point_motion_matrix
from rollbench.lowfi.statics.result import Status
from rollbench.lowfi.statics.shape import independent_columns, null_space_of_constraints
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import FREEDOMS


def unresisted_motions(system: AssemblyArrays) -> UnresistedMotions:
    """Return the rigid motions of shaft and housings that no support, spring, ball or roller resists.

    The motions are found from those of the bodies at the balls' centres, where a screw motion along the helix is exactly
    free. At the contact points, the planar sections of the model would seem to resist it.
    """
    s = system.structure
    motions = rigid_motions_of_shaft_and_housings(s, system.moment_arm)
    rows = [restraints_on_rigid_motions(s, motions)]
    by_row = motions.reshape(-1, 6, motions.shape[1])
    n = s.nodes.size
    for b in system.ball_sets:
        layout = b.problem.layout
        moved = np.zeros((2 * layout.z.size, motions.shape[1]))
        for row, sign in ((0 if b.of.carrier is None else int(b.problem.first_nodes[0, 0]), 1.0), (b.outer_body_row, -1.0)):
            if row >= 0:
                arm = layout.centre - np.array([0.0, 0.0, s.body_positions[row]])
                moved += sign * (point_motion_matrix(layout, arm) @ by_row[row]).reshape(len(moved), -1)
        rows.append(moved)
    rows += _approach_change_of_rollers(system, by_row)
    null = null_space_of_constraints(np.concatenate(rows))
    if not null.shape[0]:
        return UnresistedMotions(False, "")
    free = (motions @ null.T).reshape(-1, 6, null.shape[0])
    text = describe_rigid_motions(system, free)
    if held.loads_do_work_on(np.einsum("rkc,rk->c", free, s.load), s.load, system.moment_arm):
        why = f"{text}: no support, spring or rolling element resists it, and the loads drive it"
        return UnresistedMotions(True, why)
    rows_of = [0, *range(n, s.body_positions.size)]
    flat = free[rows_of].reshape(-1, null.shape[0])
    arms = np.tile(np.repeat([1.0, system.moment_arm], 3), len(rows_of))
    chosen = independent_columns((flat * arms[:, None]).T)
    return UnresistedMotions(False, text, tuple(6 * rows_of[k // 6] + k % 6 for k in chosen))


def describe_rigid_motions(system: AssemblyArrays, free: Array) -> str:
    """Return a description in words of rigid motions of shaft and housings, such as "rigid motion of the shaft in uz".

    Parameters
    ----------
    system
        Arrays of the assembly.
    free
        Motions ``(r, 6)`` of all shaft nodes and moving housings, or k of them ``(r, 6, k)``.
    """
    free = free.reshape(len(free), 6, -1)
    s, n = system.structure, system.structure.nodes.size
    names = {row: name for name, row in s.housing_numbers.items() if row >= 0}
    arms = np.repeat([1.0, system.moment_arm], 3)
    motions = []
    for row in (0, *range(n, s.body_positions.size)):
        size = np.abs(free[row] * arms[:, None]).max(axis=1)
        freedoms = [name for name, x in zip(FREEDOMS, size, strict=True) if x > 1e-6 * np.abs(free).max()]
        if freedoms:
            motions.append(f"{'the shaft' if row == 0 else names[row]} in {', '.join(freedoms)}")
    return "rigid motion of " + " and ".join(motions)


def pin_unresisted_motions(system: AssemblyArrays, motions: UnresistedMotions) -> AssemblyArrays:
    """Return the assembly's arrays with fixed degrees of freedom ("pins") against motions that nothing resists.

    ``motions``: these motions, with the degrees of freedom to fix; without any, ``system`` itself is returned.
    """
    if not motions.pins:
        return system
    fixed = system.structure.fixed.copy()
    fixed.flat[list(motions.pins)] = True
    return replace(system, structure=replace(system.structure, fixed=fixed))


#: Contact angle [rad] below which a contact counts as on or beyond the groove's bottom, in a bearing that carries thrust in
#: one direction only.
APEX = 1e-6


def find_opening_motion(system: AssemblyArrays) -> Array | None:
    """Find a rigid motion of shaft and housings that opens all contacts while the loads do work, by a linear program.

    Contacts are taken at their nominal angles.

    Returns
    -------
    Array | None
        Motion of all shaft nodes and moving housings ``(r, 6)`` [m, rad], with displacements up to 1 m. None if compressive
        contact forces can balance the loads.

    Raises
    ------
    ArithmeticError
        If the linear program fails.
    """
    from scipy.sparse import csr_array, hstack, vstack

    s = system.structure
    motions = rigid_motions_of_shaft_and_housings(s, system.moment_arm)
    by_row = motions.reshape(-1, 6, motions.shape[1])
    work = motions.T @ s.load.ravel()
    total = float(np.abs(s.load[:, :3]).sum() + np.abs(s.load[:, 3:]).sum() / system.moment_arm)
    if float(np.abs(work).max()) <= 1e-12 * total:
        return None
    centres = 2 * system.ball_count
    rows = [csr_array(_approach_change_of_balls(b, system, by_row)) for b in system.ball_sets]
    rows += [hstack([csr_array(x), csr_array((len(x), centres))]) for x in _approach_change_of_rollers(system, by_row)]
    answer = held.find_opening_by_linear_program(work, csr_array(vstack(rows)), restraints_on_rigid_motions(s, motions))
    return None if answer is None else np.asarray(motions @ answer).reshape(-1, 6)


def _approach_change_of_balls(ball_set: BallSet, system: AssemblyArrays, by_row: Array) -> Array:
    """Return the change of approach of each contact of one nut or bearing, per unit motion of bodies and ball centres.

    Each row of the result is a contact. The columns are the k rigid motions of shaft and housings, then two coordinates of
    every ball centre of the assembly. The single arc of a deep groove has contacts at its contact angle on both sides.

    Parameters
    ----------
    ball_set
        The nut or bearing.
    system
        Arrays of the assembly.
    by_row
        Rigid motions of all shaft nodes and housings ``(r, 6, k)``.
    """
    beta = ball_set.problem.scene.track.contact_angle
    angles = (beta, -beta) if ball_set.of.thrust == "deep groove" else (beta,)
    moved, balls = ball_set.flank_motions(by_row), system.ball_count
    used = [(int(side), angle) for side in np.flatnonzero(ball_set.problem.used_flanks) for angle in angles]
    first, change = ball_set.ball_indices.start, held.approach_change_by_motions
    return np.concatenate([change(s, angle, moved[:, s], first, balls) for s, angle in used])


def _approach_change_of_rollers(system: AssemblyArrays, by_row: Array) -> list[Array]:
    """Return for each roller bearing the change of the approach of its slices per unit of k rigid motions ``(slices, k)``.

    Parameters
    ----------
    system
        Arrays of the assembly.
    by_row
        Rigid motions of all shaft nodes and housings ``(r, 6, k)``.
    """
    signs = (1.0, -1.0)  # the approach is the motion of the cone less that of the cup
    rings = ([(k, row) for k, row in enumerate(r.ring_bodies) if row >= 0] for r in system.roller_sets)
    return [
        sum(signs[k] * (r.slice_motions(k) @ by_row[row]) for k, row in of)
        for r, of in zip(system.roller_sets, rings, strict=True)
    ]


def status_of_runaway_assembly(system: AssemblyArrays) -> Status:
    """Return the status of an assembly whose shaft or housing moved without limit in the Newton iteration.

    The status is "not held" only if a linear program proves that the contacts cannot carry the loads; otherwise it is "not
    converged".
    """
    opens = "the loads open every contact that could carry them (linear program: {})"
    search = partial(find_opening_motion, system)
    return held.status_of_runaway_body(
        search, "the shaft or a ring", lambda motion: opens.format(describe_rigid_motions(system, motion))
    )


def status_of_reversed_thrust(system: AssemblyArrays, name: str, thrust: str, angle: float, load: float) -> Status:
    """Return the status "not held" of an assembly in which a bearing for one direction of thrust is loaded in the other.

    The bearing carries thrust in one direction only, but the model continues its groove arcs beyond the bottom, so that the
    solver can find a ball loaded on the wrong side. Such a solution proves that the real bearing has no equilibrium: with
    continued arcs the energy is convex and the equilibrium unique. An equilibrium with every loaded ball on the proper side
    would also be an equilibrium of the continued arcs, and the solver would have found it instead.

    Parameters
    ----------
    system
        Arrays of the assembly.
    name
        Name of the bearing.
    thrust
        Direction of thrust that it carries.
    angle
        Contact angle [rad] of a ball on the wrong side.
    load
        Contact force [N] of this ball.
    """
    try:
        opened = find_opening_motion(system) is not None
    except ArithmeticError:
        opened = False
    if opened:
        return Status("not held", f"the load opens {name}, which carries thrust along {thrust} only (linear program)")
    on = abs(angle) < APEX
    place = "0 deg, on the groove's bottom" if on else f"{np.degrees(angle):.1f} deg, across the groove's bottom"
    reason = (
        f"no equilibrium has all loaded balls of {name} on the side of the groove that carries thrust along {thrust}: "
        f"in the only equilibrium (the energy is convex) a ball carries {load:.3g} N at a contact angle of {place}"
    )
    return Status("not held", reason, "crossed row")
