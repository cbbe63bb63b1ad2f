"""Motion of a load patch on a groove by its own load, which tests compare with closed forms and with 3D."""

import numpy as np

from rollbench.lowfi.compliance import groove


def patch_self_motion(flank, grid, force, width) -> float:
    """Sum of the harmonics around the axis, each weighted by the extent of the patch along the circumference [m/N]."""
    radius = flank.contact_position()[0]
    n = groove.sampled_harmonics(2.6 * radius / width)
    waves = groove.interpolate_harmonics(n, groove.patch_self_motion_harmonics(flank, grid, force, n))
    return float(waves @ groove.gaussian_patch_harmonic_factors(np.arange(float(waves.size)), width, radius))
