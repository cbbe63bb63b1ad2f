"""The kernels of ball screws in two engines from one source (see ``lowfi.jit``), and their view of a screw."""

from __future__ import annotations

import hashlib
from functools import cache, lru_cache
from pathlib import Path
from types import ModuleType

import numpy as np

from lowfi import jit
from lowfi.friction import engine as contact_engine
from lowfi.friction import screw_kernels

from .ellipse import Array
from .screw_groove import ON_SCREW, ScrewGroove
from .screw_kernels.arrays import Groove

_HERE = Path(__file__).parent


def engine(fast: bool) -> ModuleType:
    """The compiled kernels if ``fast``, else the same as plain Python."""
    return _compiled() if fast else screw_kernels


@cache
def _compiled() -> ModuleType:
    """The kernels' folder loaded a second time under a name whose functions ``lowfi.jit.kernel`` compiles."""
    folder = _HERE / "screw_kernels"
    contact_engine.compiled()
    drop_older(folder, _HERE / "kernel")
    return jit.load_compiled(f"{jit.COMPILED}_screw", folder)


def drop_older(folder: Path, used: Path) -> bool:
    """Remove machine code cached in ``folder`` that was made with other sources of the kernels in ``used``.

    ``lowfi.jit.drop_stale`` looks into one folder only, and these kernels call those of one contact in another.
    Returns whether anything had changed.
    """
    text = hashlib.sha256(b"".join(source.read_bytes() for source in sorted(used.glob("*.py")))).hexdigest()
    stamp = folder / "__pycache__" / "used.sha256"
    try:
        if stamp.exists() and stamp.read_text(encoding="ascii") == text:
            return False
        stamp.parent.mkdir(exist_ok=True)
        for pattern in ("*.nbi", "*.nbc"):
            for file in stamp.parent.glob(pattern):
                file.unlink(missing_ok=True)
        stamp.write_text(text, encoding="ascii")
    except OSError:  # a read-only installation: its sources do not change one by one
        return False
    return True


@lru_cache(maxsize=64)
def groove_arrays(groove: ScrewGroove) -> Groove:
    """The grooves as the kernels take them, motions scaled to surface speeds per nominal speed (see ``units``)."""
    unit, speed, pair, h = units(groove), nominal_speed(groove), groove.pair, groove.constants
    scale = speed / unit
    ends = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    at = groove.maps(np.repeat(ends[:, None, :], 4, axis=1))[0][:, 0] * scale
    middle = 0.5 * (at[0] + at[1])  # maps are affine in the normal, so that three directions tell them
    affine = np.stack([middle, at[0] - middle, at[2] - middle])
    ride = np.where(ON_SCREW, groove.screw_speed, groove.nut_speed) / scale[0]
    nominal = np.array([groove.nominal_orbit, 0.0, 0.0, 0.0]) / scale
    affine, ride, C_a, C_b, nominal, first, second = map(
        plain_array, (affine, ride, h.C_a, h.C_b, nominal, pair.first / unit, pair.second / unit)
    )
    return affine, ride, C_a, C_b, nominal, first, second, float(pair.closing / groove.radius), float(speed)


def plain_array(values: Array) -> Array:
    """Contiguous floats: machine code is made for each kind of array that comes along."""
    return np.ascontiguousarray(values, dtype=float)


def units(groove: ScrewGroove) -> Array:
    """Levers (4,) [m] from omega_B, omega_x, omega_y, omega_z to speeds."""
    return np.array([groove.radius, groove.ball_radius, groove.ball_radius, groove.ball_radius])


def nominal_speed(groove: ScrewGroove) -> float:
    """Speed of the nut along the path relative to the screw [m/s]; one at rest."""
    return float(abs(groove.speed) * groove.radius) or 1.0
