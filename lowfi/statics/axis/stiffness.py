"""Tangent stiffness of an assembly where it is asked for, and of each set by itself."""

from __future__ import annotations

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.axis.system import BallSet, System
from rollbench.lowfi.statics.kernel_types import AxisSystem, RowState
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly


def asked(assembly: Assembly) -> float | str:
    """Station [m] or housing whose motion and stiffness are asked for: as the assembly says, else the first housing that is
    loaded, the first load, the first set."""
    if assembly.stiffness_at is not None:
        return assembly.stiffness_at
    loaded = [h.name for h in assembly.housings if any(h.force) or any(h.moment)]
    if loaded:
        return loaded[0]
    return assembly.loads[0].at if assembly.loads else assembly.sets[0].position


def asked_row(system: System) -> int:
    """Row of motions whose stiffness is asked for; -1 for a housing that stands."""
    at, s = asked(system.assembly), system.structure
    return s.row[at] if isinstance(at, str) else int(np.abs(s.nodes - at).argmin())


def whole_stiffness(
    system: System, engine: ModuleType, given: AxisSystem, state: RowState, hessians: Array
) -> Array | None:
    """Stiffness (6, 6) [N/m, N, N m] against wrenches on the row that is asked about, all else free to follow.

    Rows and columns of held freedoms are nan. None where the row stands, or where contacts carry too little to be stiff.
    """
    row = asked_row(system)
    if row < 0:
        return None
    r = system.structure.stations.size
    size = given.shaft.start[-1]
    base, values, step = np.zeros(size), np.empty(size), np.empty((r, 6))
    engine.add_axis(base, given.shaft)
    if not engine.tangent(given, state, hessians, base, values, np.zeros(6)):
        return None
    compliance = np.empty((6, 6))
    for k in range(6):
        load = np.zeros((r, 6))
        load[row, k] = 1.0
        engine.solve_lines(given.shaft, values, load, step)
        compliance[:, k] = step[row]
    return inverse(compliance, ~system.structure.fixed[row], system.arm)


def inverse(compliance: Array, free: NDArray[np.bool_], arm: float) -> Array | None:
    """Stiffness (6, 6) of the free freedoms from a compliance, nan for the others; arm [m]: of one size in both units.
    None for what is no compliance: contacts that carry nothing leave round-off.
    """
    rows = np.flatnonzero(free)
    out = np.full((6, 6), np.nan)
    if rows.size:
        size = np.where(rows < 3, 1.0, 1.0 / arm)
        scaled = compliance[np.ix_(rows, rows)] / size[:, None] / size[None, :]
        if not (np.diag(scaled) > 0.0).all():
            return None
        try:
            stiffness = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return None
        stiffness = stiffness / size[:, None] / size[None, :]
        out[np.ix_(rows, rows)] = 0.5 * (stiffness + stiffness.T)
    return out


def rigid_rows(b: BallSet, stations: Array) -> Array:
    """Motion (N, 4, 6) of the inner flanks of a set, two axes each, by its inner part as a rigid body at its position.

    stations: of all rows [m].
    """
    return b.moved(rigid_transport(stations - b.of.position))[:, :2].reshape(-1, 4, 6)


def set_stiffness(b: BallSet, stations: Array, hessians: Array) -> Array:
    """Stiffness (6, 6) of a set of N balls against motions of its inner part at its position, the outer one held.

    hessians (N, 4, 4): of the balls' energy by the motion of their screw flanks [N/m].
    """
    rows = rigid_rows(b, stations)
    return np.asarray(np.einsum("nai,nab,nbj->ij", rows, hessians, rows))
