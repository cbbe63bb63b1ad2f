"""Mesh choices of the 3D reference, and the sizes of contacts that they follow; no finite elements are imported."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.fields import keyed, usual

#: Expected semi-axes are rounded to this length [m], so that like scenes share their patches.
ROUNDING = 5e-6


@keyed
@dataclass(frozen=True)
class Settings:
    """Mesh choices of the 3D reference; lengths in m.

    b_over_h: cells across the short semi-axis; semi: semi-axes (a, b) of a typical contact; reach: how far contacts reach
    from their nominal middle across and along the groove; fine, coarse: element sizes of the coarse bodies near and away
    from sockets; ball_fine, ball_coarse: those of balls; cuts: subdivisions of the sockets' edges across, in depth and
    along; growth: ratio of neighbouring cells of a patch outside the contact zone; own_cuts, own_sizes, own_ball_sizes:
    subdivisions and element sizes (near, away) of the submodels of one contact's groove and ball; cell: element size of
    the shafts that say what a cut does; modes, ball_modes: smooth modes kept per patch of the bodies, of the ball; element:
    ``"Q2"`` patches on second-order bodies, or ``"P1"``: first-order tetrahedra of ``tet`` size around each contact, on
    first-order bodies, as the source's mesh, without submodels.
    """

    b_over_h: float = usual(4.0)
    semi: tuple[float, float] = usual((0.40e-3, 0.105e-3))
    reach: tuple[float, float] = usual((0.40e-3, 0.105e-3))
    fine: float = usual(1.0e-3)
    coarse: float = usual(5.0e-3)
    ball_fine: float = usual(0.35e-3)
    ball_coarse: float = usual(0.8e-3)
    cuts: tuple[int, int, int] = usual((3, 2, 3))
    growth: float = usual(1.6)
    own_cuts: tuple[int, int, int] = usual((4, 4, 4))
    own_sizes: tuple[float, float] = usual((0.5e-3, 2.5e-3))
    own_ball_sizes: tuple[float, float] = usual((0.3e-3, 0.6e-3))
    cell: float = usual(4.5e-3)
    modes: int = usual(16)
    ball_modes: int = usual(24)
    element: str = usual("Q2")
    tet: float = usual(0.08e-3)


def rounded(lengths: tuple[float, float]) -> tuple[float, float]:
    """Lengths [m] rounded up, so that like scenes share their patches."""
    a, b = (max(1.0, float(np.ceil(x / ROUNDING - 1e-9))) * ROUNDING for x in lengths)
    return a, b
