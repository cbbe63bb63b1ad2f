"""Many specimens of one screw that are not solved on their flanks alone (``press``, ``flanks``): more balls, too far off.

Each goes from the solution without random errors, by the stiffness there, else by Newton's method.

The members of an ensemble differ by micrometres, so that the stiffness of their common start, factored once, serves all of
them: the motion is corrected by it until the member's own equations hold (the chord method; its error falls by the change
of stiffness, some per cent, at every step). What it does not solve soon, Newton's method solves from the same start.
"""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import (
    Array,
    BeamArrays,
    BeamContacts,
    BeamOptions,
    BeamSlopes,
    BeamState,
    MemberArrays,
    MemberStates,
    Outcome,
)

from .ball import FORCE, nudge
from .banded import factor_band, substitute_band, substitute_columns, take
from .newton import (
    CONVERGED,
    ITERATIONS,
    ROUND_OFF,
    advance,
    assemble,
    evaluate,
    evaluate_beam,
    flank_shift,
    pull,
    residual_of,
    solve_beam,
)
from .pair import pair_alone

#: Steps by the common stiffness, the first ones that may do what they will (balls find their centres), and the share of the
#: residual that two of the others may leave: Newton's method is faster beyond.
CHORDS, FREE, LEFT = 16, 3, 0.12


@kernel
def common_stiffness(
    beam: BeamArrays, contacts: BeamContacts, state: BeamState, options: BeamOptions, out: BeamSlopes, band: Array
) -> bool:
    """Factor the stiffness at a state into the lower band; False where it is not positive definite."""
    evaluate(beam, contacts, state, out)
    assemble(band, beam, contacts, out.hessians, ROUND_OFF * max(0.0, beam.band[:, 0].max()), options.arm)
    return bool(factor_band(band))


@kernel
def answers(
    beam: BeamArrays,
    contacts: BeamContacts,
    state: BeamState,
    options: BeamOptions,
    rows: tuple[Array, Array],
    found: tuple[Array, Array, Array],
) -> bool:
    """Answers to unit forces at the stiffness of a state. rows: functions of the motions of the nodes, their coefficients
    (c, m), and the freedoms (c,) from which on these are; found: motions of the nodes (6 n, c) by the force of each, the
    functions (c, c) by these, and the contacts' part of the stiffness (N, 4, 4). False where that stiffness is not positive
    definite."""
    n, (arms, first), (motions, reach, hessians) = state.q.shape[0], rows, found
    out = BeamSlopes(np.empty((n, 6)), hessians)
    band = np.empty((6 * n, options.half_band + 1))
    if not common_stiffness(beam, contacts, state, options, out, band):
        return False
    motions[:, :], reach[:, :] = 0.0, 0.0
    for a in range(arms.shape[0]):
        for k in range(arms.shape[1]):
            j = first[a] + k
            motions[j, a] = 0.0 if beam.fixed[j // 6, j % 6] else arms[a, k]
    substitute_columns(band, motions)
    for a in range(arms.shape[0]):
        for k in range(arms.shape[1]):
            take(reach[a], motions[first[a] + k], -arms[a, k])
    return True


@kernel
def glance(
    beam: BeamArrays, contacts: BeamContacts, state: BeamState, gradient: Array, room: tuple[Array, Array]
) -> tuple[float, float]:
    """Gradient (n, 6) of the energy at the state, every ball taken one step further (see ``ball.nudge``).

    room: shifts (4, 2) of zero, pulls (2, 2). Returns the largest force met and the largest net force on a ball [N].
    """
    node, B, geometry, _, r_ball, profile, tiny = contacts
    q, d, p, contact = state
    shift, pulls = room
    _, scale = evaluate_beam(beam, q, d, gradient)
    flat, slopes, m, loose = q.ravel(), gradient.ravel(), B.shape[3], 0.0
    for i in range(r_ball.shape[0]):
        if m == 6:  # by its number: the compiler then unrolls the loops
            flank_shift(contacts, flat, i, 6, shift)
        else:
            flank_shift(contacts, flat, i, m, shift)
        net = nudge(p[i], shift, geometry[i], r_ball[i], profile, tiny, contact[i], pulls)
        largest = 0.0
        for s in range(4):
            largest = max(largest, contact[i, s, FORCE])
        scale, loose = max(scale, largest), max(loose, net * largest)
        for s in range(2):
            if contact[i, s, FORCE] > 0.0:
                if m == 6:
                    pull(slopes, B, i, s, 6, 6 * node[i, s], pulls[s, 0], pulls[s, 1])
                else:
                    pull(slopes, B, i, s, m, 6 * node[i, s], pulls[s, 0], pulls[s, 1])
    return scale, loose


@kernel
def follow(
    beam: BeamArrays,
    contacts: BeamContacts,
    state: BeamState,
    options: BeamOptions,
    out: BeamSlopes,
    band: Array,
    step: Array,
    room: tuple[Array, Array],
) -> Outcome:
    """Correct the state by a stiffness factored before, in the lower band; step (n, 6) and room: see
    ``glance``. Status as in ``solve_beam``."""
    q, d, fixed = state.q, state.d, beam.fixed
    before, last, status, scale, residual, tried = 1e300, 1e300, ITERATIONS, 0.0, 0.0, 0
    pair = pair_alone(contacts) if contacts.B.shape[3] == 6 else -1
    for tried in range(1, CHORDS + 1):
        if pair >= 0:
            scale, loose = evaluate(beam, contacts, state, out)[1], 0.0
        else:
            scale, loose = glance(beam, contacts, state, out.gradient, room)
        scale = max(scale, options.floor)
        unbalanced = residual_of(out.gradient, fixed, scale, options.arm)
        residual = max(unbalanced, loose / scale)
        if residual <= options.tolerance:
            status = CONVERGED
            break
        if tried > FREE and not residual <= LEFT * before:
            break
        before, last = last, residual
        if unbalanced <= options.tolerance:  # the screw is where it has to be: what is left are steps of the balls
            continue
        for i in range(q.shape[0]):
            for k in range(6):
                step[i, k] = 0.0 if fixed[i, k] else -out.gradient[i, k]
        substitute_band(band, step.ravel())
        advance(q, d, beam.lengths, q[0], d, step, 1.0)
    return Outcome(status, tried, tried, residual, 0.0, scale)


@kernel
def ensemble(
    beam: BeamArrays,
    contacts: BeamContacts,
    begin: BeamState,
    options: BeamOptions,
    members: MemberArrays,
    found: MemberStates,
) -> int:
    """Solve many specimens of one screw from the same start; they differ in ball radii, groove centres and lever arms.

    Every member begins where ``begin`` is, the solution of ``contacts``, which stays as it is, so that calls may run side
    by side; fills ``found``. Returns how many were left to Newton's method.
    """
    state = BeamState(begin.q.copy(), begin.d.copy(), begin.p.copy(), begin.contact.copy())
    q, d, p, contact = state
    history = np.empty(options.most + 1)
    n = q.shape[0]
    out, step = BeamSlopes(np.empty((n, 6)), np.zeros((contacts.node.shape[0], 4, 4))), np.empty((n, 6))
    band = np.empty((6 * n, options.half_band + 1))
    room = np.zeros((4, 2)), np.zeros((2, 2))
    known = options.floor > 0.0 and common_stiffness(beam, contacts, state, options, out, band)
    left, shared = 0, members.B.shape[0] == 1
    for m in range(members.r_ball.shape[0]):
        own = BeamContacts(
            contacts.node,
            members.B[0 if shared else m],
            members.geometry[m],
            members.closure[m],
            members.r_ball[m],
            contacts.profile,
            contacts.tiny,
        )
        q[:], d[:], p[:] = begin.q, begin.d, begin.p
        outcome = Outcome(ITERATIONS, 0, 0, 1.0, 0.0, 0.0)
        if known:
            outcome = follow(beam, own, state, options, out, band, step, room)
        if outcome.status != CONVERGED:
            left += 1
            q[:], d[:], p[:], contact[:] = begin.q, begin.d, begin.p, begin.contact
            outcome = solve_beam(beam, own, state, options, history)
        found.status[m], found.residual[m] = outcome.status, outcome.residual
        found.q[m], found.p[m] = q, p
        for i in range(contact.shape[0]):
            for s in range(4):
                found.force[m, i, s] = contact[i, s, FORCE]
    return left
