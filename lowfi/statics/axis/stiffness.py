"""Tangent stiffness of an assembly where it is asked for, and of each set alone."""

from __future__ import annotations

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from lowfi.statics.axis.system import System
from lowfi.statics.records import AxisState
from lowfi.statics.shape import rigid_transport

Array = NDArray[np.float64]


def asked_station(system: System) -> tuple[int, str]:
    """Row of motions whose stiffness is asked for, and its name: a housing, or a station of the shaft.

    Where the assembly does not say: the first housing that is loaded, else the first load on the shaft, else the first set.
    """
    assembly, s = system.assembly, system.structure
    asked = assembly.stiffness_at
    if asked is None:
        loaded = [h.name for h in assembly.housings if s.row[h.name] >= 0 and (any(h.force) or any(h.moment))]
        asked = loaded[0] if loaded else assembly.loads[0].at if assembly.loads else assembly.sets[0].position
    if isinstance(asked, str):
        return s.row[asked], asked
    row = int(np.abs(s.nodes - asked).argmin())
    return row, f"shaft at {1e3 * float(s.nodes[row]):.6g} mm"


def whole_stiffness(system: System, engine: ModuleType, state: AxisState, hessians: Array) -> Array | None:
    """Stiffness (6, 6) [N/m, N, N m] against wrenches on the row that is asked about, all else free to follow.

    Rows and columns of held freedoms are nan. None where the row stands, or where contacts carry too little to be stiff.
    """
    row, _ = asked_station(system)
    if row < 0:
        return None
    r = system.structure.stations.size
    size = system.axis.start[-1]
    base, values, step = np.zeros(size), np.empty(size), np.empty((r, 6))
    engine.add_axis(base, system.axis)
    if not engine.tangent(system.axis, system.contacts, system.slices, state, hessians, base, values, np.zeros(6)):
        return None
    compliance = np.empty((6, 6))
    for k in range(6):
        load = np.zeros((r, 6))
        load[row, k] = 1.0
        engine.solve_lines(system.axis, values, load, step)
        compliance[:, k] = step[row]
    free = np.flatnonzero(~system.structure.fixed[row])
    out = np.full((6, 6), np.nan)
    if free.size:
        arms = np.where(free < 3, 1.0, 1.0 / system.arm)  # both units of one size
        inverse = np.linalg.inv(compliance[np.ix_(free, free)] / arms[:, None] / arms[None, :])
        inverse = inverse / arms[:, None] / arms[None, :]
        out[np.ix_(free, free)] = 0.5 * (inverse + inverse.T)
    return out


def set_stiffness(nodes: Array, B: Array, hessians: Array, position: float) -> Array:
    """Stiffness (6, 6) of a set of N balls against motions of its inner part at ``position`` [m], the outer one held.

    nodes (N, 2): stations of the flanks' motions [m]; B (N, 2, 2, 6): their motion; hessians (N, 4, 4): of the balls'
    energy by the motion of their screw flanks [N/m].
    """
    to = np.array([[rigid_transport(float(z - position)) for z in row] for row in nodes])
    rows = np.einsum("nsak,nskj->nsaj", B, to).reshape(len(nodes), 4, 6)
    return np.asarray(np.einsum("nai,nab,nbj->ij", rows, hessians, rows))
