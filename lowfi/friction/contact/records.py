"""What the kernels of one contact return, as named tuples: the plain and the compiled copy share them."""

from typing import NamedTuple


class DissipationTerms(NamedTuple):
    """Dissipation D of one contact per friction bound mu F [m/s], and its derivatives.

    By the sliding velocity (vx, vz) [m/s], the spin [rad/s] and the regularising speed [m/s].
    """

    value: float
    by_vx: float
    by_vz: float
    by_spin: float
    by_speed: float
    xx: float
    xz: float
    zz: float
    x_spin: float
    z_spin: float
    spin_spin: float
