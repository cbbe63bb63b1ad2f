"""Many chains: what is kept of each."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.jit import kernel

from .ball import Array
from .newton import newton


@kernel
def batch(errors: Array, loads: Array, compliance: float, law: int, p: Array, out: Array) -> None:
    """Solve every chain ``errors`` (n, M) [m] under every load (L,) [N].

    out (n, L, 7): smallest and largest contact load [N], loaded balls, motion u of ball 1 [m], the same of the first
    loaded ball, stiffness dF/du_1 [N/m], residual over the load.
    """
    n, m = errors.shape
    u, work = np.empty(m), np.empty((3, m))
    for i in range(n):
        for k in range(loads.size):
            _, residual, stiffness = newton(errors[i], loads[k], compliance, law, p, u, work)
            q = work[0]
            first, count = -1, 0
            for j in range(m):
                if q[j] > 0.0:
                    count += 1
                    if first < 0:
                        first = j
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = q.min(), q.max(), count
            out[i, k, 3], out[i, k, 4] = u[0], u[first]
            out[i, k, 5], out[i, k, 6] = stiffness, residual
