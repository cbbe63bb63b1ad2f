"""The weak forms of the 3D reference. scikit-fem's `form.assemble(basis)` evaluates them as they stand.

Displacements u, virtual ones v [m]; small strains; isotropic elasticity of constant Young's modulus and Poisson's ratio.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from skfem import BilinearForm, LinearForm
from skfem.helpers import ddot, sym_grad
from skfem.models.elasticity import lame_parameters, linear_stress

Stress = Callable[[Any], Any]


def hooke(young: float, poisson: float) -> Stress:
    """C: strain to stress [Pa]. Raises ValueError outside E > 0, -1 < nu < 0.5."""
    if not (young > 0.0 and -1.0 < poisson < 0.5):
        raise ValueError(f"Young's modulus {young}, Poisson's ratio {poisson}: need E > 0 and -1 < nu < 0.5")
    law: Stress = linear_stress(*lame_parameters(young, poisson))
    return law


def elasticity(young: float, poisson: float) -> Any:
    """int C(eps(u)) : eps(v) dV, young [Pa]."""
    C = hooke(young, poisson)

    def energy(u: Any, v: Any, _: Any) -> Any:
        return ddot(C(sym_grad(u)), sym_grad(v))

    return BilinearForm(energy)


def share(axis: int | None = None) -> Any:
    """int N_i dA, or dV: what each node of a scalar space carries of an area or a volume; with an axis int x_axis N_i, of
    its first moment."""

    def weight(v: Any, w: Any) -> Any:
        return v if axis is None else w.x[axis] * v

    return LinearForm(weight)
