"""Many specimens of one screw: Newton's method from the solution of the screw without random errors."""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import BeamArrays, BeamContacts, BeamState, MemberArrays, MemberStates, Options

from .ball import FORCE
from .newton import solve_beam


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
