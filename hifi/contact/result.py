"""Record of a solved contact; `hifi.contact.balls` solves it.

Contact pairs i carry forces lambda_i >= 0 [N], pressing the bodies apart, and have gaps g_i >= 0 [m]:

    g = g0 + C lambda - N y,   lambda >= 0,   g >= 0,   lambda_i g_i = 0,   N^T lambda = f          (1)

g0: gaps of the undeformed bodies at rest; C: compliance, symmetric positive definite; y: rigid motions of the free
bodies (translations [m], rotations [rad]), column j of N being the gap closed by a unit of motion j; f: loads on them
[N, N m], positive where they do work in a closing motion. These are the optimality conditions of the convex problem
min 1/2 lambda^T C lambda + g0^T lambda over lambda >= 0 with N^T lambda = f, so a solution's forces are unique.
"""

from __future__ import annotations

from dataclasses import dataclass

from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class ContactResult:
    """Solution of (1), or the last state and the reason why it is none.

    forces: (n,) [N]; gaps: (n,) [m], round-off on closed pairs; motions: (k,) rigid motions y [m, rad]; iterations: of
    Newton's method; status: "converged", or why not; equilibrium: the largest unbalanced force over the largest force on
    a ball.
    """

    forces: Array
    gaps: Array
    motions: Array
    iterations: int
    status: str
    equilibrium: float

    @property
    def converged(self) -> bool:
        """Whether (1) holds."""
        return self.status == "converged"
