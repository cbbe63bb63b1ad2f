"""Many specimens of one screw: the answers of their common start to forces, and Newton's method from it for those that are
not solved on their flanks alone (``flanks``): too many balls, too far off."""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import (
    Array,
    BeamArrays,
    BeamContacts,
    BeamSlopes,
    BeamState,
    MemberArrays,
    MemberStates,
    Options,
)

from .ball import FORCE
from .banded import factor_band, substitute_columns, take
from .newton import ROUND_OFF, assemble, evaluate, solve_beam


@kernel
def answers(
    beam: BeamArrays,
    contacts: BeamContacts,
    state: BeamState,
    options: Options,
    rows: tuple[Array, Array],
    out: tuple[Array, Array, Array],
) -> bool:
    """Answers to unit forces at the stiffness of a state. rows: functions of the motions of the nodes, their coefficients
    (c, m), and the freedoms (c,) from which on these are; out: motions of the nodes (6 n, c) by the force of each, the
    functions (c, c) by these, and the contacts' part of the stiffness (N, 4, 4). False where that stiffness is not positive
    definite."""
    n, (arms, first), (motions, reach, hessians) = state.q.shape[0], rows, out
    band = np.empty(beam.band.shape)
    evaluate(beam, contacts, state, BeamSlopes(np.empty((n, 6)), hessians))
    assemble(band, beam, contacts, hessians, ROUND_OFF * max(0.0, beam.band[:, 0].max()), options.arm)
    if not factor_band(band):
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
def ensemble(
    beam: BeamArrays, contacts: BeamContacts, begin: BeamState, options: Options, members: MemberArrays, out: MemberStates
) -> None:
    """Solve many specimens of one screw from the same start; they differ in ball radii, groove centres and lever arms.

    Every member begins where ``begin`` is, the solution of ``contacts``, which stays as it is, so that calls may run side
    by side; fills ``out``.
    """
    state = BeamState(begin.q.copy(), begin.d.copy(), begin.p.copy(), begin.contact.copy())
    history, shared = np.empty(options.most + 1), members.B.shape[0] == 1
    for m in range(members.r_ball.shape[0]):
        of_member = BeamContacts(
            contacts.node,
            members.B[0 if shared else m],
            members.geometry[m],
            members.closure[m],
            members.r_ball[m],
            contacts.profile,
            contacts.tiny,
        )
        for to, start in ((state.q, begin.q), (state.d, begin.d), (state.p, begin.p)):
            to[:] = start
        outcome = solve_beam(beam, of_member, state, options, history)
        out.status[m], out.residual[m] = outcome.status, outcome.residual
        out.q[m], out.p[m] = state.q, state.p
        out.force[m] = state.contact[:, :, FORCE]
