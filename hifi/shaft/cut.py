"""What the cut end of a grooved shaft does: where a flat rigid section ends it, and the real shaft goes on.

A long grooved shaft under a constant wrench is on the average over a lead a uniform beam. About that beam its sections sway
with the groove: an axial force bends it towards the groove, and over half a lead the other way. A rigid section that ends
it stops the sway in one phase, and holds the cross-section flat besides. So of a shaft with length L along z, cut and
rigid at both ends and held at the lower one (a), the upper end (b) moves by the flexibility

    F = U(L) + T(L) A T(L)^T + R_b E R_b^T,   A = R_a M E M R_a^T,

U that of a uniform cantilever, T the transport along the axis, E ``(6, 6)`` that of one cut: motion of the rigid section
against the beam, by the wrench on it, in the frame of the cut: origin on the axis, x towards the middle of the groove, z
along the screw; R turns that frame by the groove's azimuth at the cut. The lower cut is the upper one seen after half a
turn M about x, which maps a helix, of either hand and with any number of starts, onto itself. What both ends do to each
other is left out: it decays within a diameter or so.

E follows from shafts of several lengths by least squares. Two of one and two times a whole number of leads leave open
what changes its sign from end to end, so one must end in another phase.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.hifi.elements.rigid import transport
from rollbench.hifi.shaft.beam import uniform_cantilever
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap

#: Half a turn about x of motions and wrenches.
HALF_TURN = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
_UPPER = np.triu_indices(6)
#: Symmetric matrices ``(21, 6, 6)`` of one entry each.
_UNITS = np.zeros((21, 6, 6))
_UNITS[(np.arange(21), *_UPPER)] = _UNITS[(np.arange(21), *_UPPER[::-1])] = 1.0


def groove_azimuth(m: GrooveMap, z: float) -> float:
    """Azimuth [rad] of the middle of the first start's groove where it passes the station z [m]."""
    return m.phase + (z - m.z0) / m.rg


def turned(flexibility: Array, azimuth: float) -> Array:
    """A flexibility ``(6, 6)`` in the fixed frame from that in a frame at an azimuth [rad]."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    R = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
    return np.asarray(R @ flexibility @ R.T)


def at_low(cut: Array, m: GrooveMap, z: float) -> Array:
    """Flexibility ``(6, 6)``, in the fixed frame, of a lower end at z [m]: motion of the beam against the held section."""
    return turned(HALF_TURN @ cut @ HALF_TURN, groove_azimuth(m, z))


def at_high(cut: Array, m: GrooveMap, z: float) -> Array:
    """Flexibility ``(6, 6)``, in the fixed frame, of an upper end at z [m]: motion of the held section against the beam."""
    return turned(cut, groove_azimuth(m, z))


def cut_flexibility(m: GrooveMap, flexibilities: Sequence[tuple[float, Array]], per_length: Array) -> Array:
    """E ``(6, 6)`` of one cut [m/N, 1/N, 1/(N m)] of shafts with their middle at ``m.z0``.

    flexibilities: length [m] and F ``(6, 6)`` of every shaft; per_length: uniform flexibility ``(6, 6)`` of a metre. How a
    shear force bends and a moment shears, alike in all directions, is fitted beside E. The shear flexibility is taken as
    given: another one is the same as another meaning of the beam's rotation, and E makes up for it.
    """
    unit = np.array([m.R, m.R, m.R, 1.0, 1.0, 1.0])
    scale = np.outer(unit, unit)
    chiral = np.zeros((6, 6))
    chiral[[0, 1, 3, 4], [3, 4, 0, 1]] = m.R
    columns, wanted = [], []
    for length, F in flexibilities:
        rows = [*(_ends(m, length, e * scale) for e in _UNITS), uniform_cantilever(length, chiral)]
        columns.append(np.array([(x / scale)[_UPPER] for x in rows]).T)
        wanted.append(((F - uniform_cantilever(length, per_length)) / scale)[_UPPER])
    coefficients = np.linalg.lstsq(np.concatenate(columns), np.concatenate(wanted))[0]
    return np.asarray(np.tensordot(coefficients[:-1], _UNITS, 1) * scale)


def _ends(m: GrooveMap, length: float, cut: Array) -> Array:
    """Motion ``(6, 6)`` of the upper end of a shaft by what both of its cuts do."""
    T, half = transport(length), length / 2.0
    return np.asarray(T @ at_low(cut, m, m.z0 - half) @ T.T + at_high(cut, m, m.z0 + half))
