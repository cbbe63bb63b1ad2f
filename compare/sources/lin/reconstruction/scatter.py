"""What an unstructured mesh makes of equal contacts: the scatter of their approaches, and of the errors printed.

A contact of case 1 is meshed as the source says, by first-order tetrahedra of about 0.08 mm, with several sizes near
that: each is another unstructured mesh. Its approach, with what it falls by with the size taken out, scatters by some share
s. A ball's load then changes as by a closure of s times the approach at each of its contacts, and what a closure does is
seen in case 2, whose ball 17 is 1 um too large in radius: closed by 1 um at both contacts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.meshes.arrays import Array

#: Sizes of the tetrahedra [m], radius of the body of influence [m], growth beyond it, edge of the block [m].
SIZES = (0.074e-3, 0.076e-3, 0.078e-3, 0.079e-3, 0.080e-3, 0.081e-3, 0.082e-3, 0.084e-3, 0.086e-3)
RADIUS, GROWTH, BLOCK = 0.6e-3, 0.3, 4e-3
#: Ball of case 2 that is too large, and by how much [m] in radius.
LARGE, OVERSIZE = 16, 1e-6
#: Drawn pairs of meshes of case 1 and case 2.
DRAWN = 5000
#: Approach of such a contact by Hertz [m], and what `mesh_scatter` finds: mean error of the approach and its scatter [%].
APPROACH, BIAS, SCATTER = 6.4839e-6, -4.4, 0.33


@dataclass(frozen=True)
class MeshScatter:
    """approach: of the contact by Hertz [m]; bias: mean error of the approaches [%]; percent: their scatter [%], of one
    contact between two bodies meshed apart."""

    approach: float
    bias: float
    percent: float


def mesh_scatter() -> MeshScatter:
    """Scatter of a contact's approach over meshes of about the source's size. Needs gmsh."""
    from rollbench.hifi.contact.block import JOBS, SOURCE_COARSE, on_mesh
    from rollbench.meshes.block import Influence, tetrahedra

    job = JOBS["B"]
    found = []
    for size in SIZES:
        mesh = tetrahedra(1, Influence(size, (RADIUS,) * 3, GROWTH, SOURCE_COARSE), BLOCK)
        found.append(on_mesh(job, mesh, job.exact.semi_y / size).approach)
    error = 100.0 * (np.array(found) / job.exact.approach - 1.0)
    trend = np.polyval(np.polyfit(SIZES, error, 1), SIZES)
    alone = float(np.linalg.norm(error - trend) / np.sqrt(len(SIZES) - 2))
    return MeshScatter(float(job.exact.approach), float(error.mean()), alone / np.sqrt(2.0))


def share_of_closure(solid: tuple[Array, ...]) -> float:
    """Relative change of a ball's load over that of one of its approaches, from loads of cases 1 and 2 in 3D ``(n, 4)``."""
    before, after = (load[LARGE, 0] for load in solid)
    return float((after / before - 1.0) * 0.5 * APPROACH / OVERSIZE)


def drawn_errors(low: tuple[Array, ...], solid: tuple[Array, ...], percent: float, *, of_load: bool = True) -> Array:
    """Largest and RMS error of case 1, then of case 2, ``(DRAWN, 4)`` [%], with every contact's approach scattered by
    ``percent``, the two cases meshed apart; loads ``(n, 4)`` [N] of both; of_load: of each load, else of the mean load.

    Of both flanks the screw's: a ball in two-point contact has one load.
    """
    rng, share, out = np.random.default_rng(1), share_of_closure(solid), []
    for a, b in zip(low, solid, strict=True):
        change = 0.01 * percent * share * rng.normal(size=(DRAWN, len(b), 2)).sum(axis=2)
        meshed = b[:, 0] * (1.0 - change)
        meshed *= b[:, 0].sum() / meshed.sum(axis=1, keepdims=True)  # the axial force is the same
        errors = np.asarray(error_percent(a[:, 0], meshed, None if of_load else meshed.mean(axis=1, keepdims=True)))
        out += [np.abs(errors).max(axis=1), np.sqrt((errors**2).mean(axis=1))]
    return np.stack(out, axis=1)


def probability(errors: Array, falls: float, rises: float) -> float:
    """Share of `drawn_errors` whose largest error falls and whose RMS rises by so much [%] or more from case 1 to 2."""
    return float(((errors[:, 0] - errors[:, 2] >= falls) & (errors[:, 3] - errors[:, 1] >= rises)).mean())
