"""The source's own formulation: its Jacobian, and its agreement with the energy solver."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import FLANK_ERRORS, NO_PROFILES, relative, small_screw, solved, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.as_source import newton as as_source
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.parts import BallErrors

CASES = ("lin-case1", "lin-case2", "lin-case3", "lin-case3-offset")


@pytest.mark.parametrize("partition", ["nodal", "source"])
@pytest.mark.parametrize("case", CASES)
def test_both_solvers_agree_on_the_same_equations(case, partition):
    """Lin 2.18-2.21 moves the station and arm with gamma; the energy's arcs turn rigidly: some 1e-4 of the load."""
    scene = with_ingredients(catalogue.scene(case), partition=partition)
    source, moving = (as_source.solve_by_lin_equations(scene, kinematics=name) for name in ("arc", "source"))
    energy = solved(scene)
    assert source.status == moving.status == "converged"
    assert relative(source.contact_loads, energy.load) < 1e-8
    loaded = energy.load > 0.0
    assert source.contact_angles[loaded] == pytest.approx(energy.contact_angle[loaded], abs=1e-8)
    assert 1e-8 < relative(moving.contact_loads, energy.load) < 2e-4


def test_both_solvers_agree_with_pitch_and_roundness_errors():
    scene = small_screw(count=12, turns=2.0, force=(0.0, 200.0, 2000.0))
    scene = replace(scene, errors=replace(FLANK_ERRORS, balls=BallErrors(oversize=4e-6), **NO_PROFILES))
    source = as_source.solve_by_lin_equations(scene, kinematics="arc")
    assert source.status == "converged"
    assert relative(source.contact_loads, solved(scene).load) < 1e-8


def test_newton_from_the_nominal_state_and_other_starts():
    """Singular at once without preload, where no contact is closed; convergent with it, to the same loads from all."""
    loose = as_source.solve_by_lin_equations(catalogue.scene("lin-case1"), start_values="nominal")
    assert loose.status.startswith("singular Jacobian at iteration 1")
    assert not loose.converged
    preloaded, starts = catalogue.scene("lin-case3"), ("nominal", "guess", "load steps")
    nominal, *others = (as_source.solve_by_lin_equations(preloaded, start_values=s) for s in starts)
    for other in others:
        assert nominal.status == other.status == "converged"
        assert relative(other.contact_loads, nominal.contact_loads) < 1e-9


def test_rigid_screw_is_refused():
    with pytest.raises(ValueError, match="beam"):
        as_source.solve_by_lin_equations(small_screw(screw="rigid"))


def test_the_source_model_keeps_the_constants_of_error_free_parts():
    """Printed loads are those of error-free constants, whatever an oversize does to them; the equations take either."""
    scene = with_ingredients(catalogue.scene("lin-case3"), partition="source")
    model, row = as_source.solve_lin_equations_as_static_result(scene), hertz_without_errors(scene).C
    assert model.converged
    assert model.hertz_C == pytest.approx(np.tile(row, (32, 1)), rel=1e-15)
    old = with_ingredients(scene, hertz="error-free")
    assert relative(as_source.solve_by_lin_equations(old, kinematics="arc").contact_loads, solved(old).load) < 1e-8
    assert relative(solved(scene).load, solved(old).load) > 1e-3


@pytest.mark.parametrize("case", ["lin-case1", "lin-case3-offset"])
def test_reactions_are_those_of_the_source_s_own_equations(case):
    """Sums of loads, reactions and contact forces; with the arcs of the energy solver both models have one reaction."""
    scene = catalogue.scene(case)
    result = as_source.solve_lin_equations_as_static_result(scene)
    expected = solved(scene).equilibrium.reaction_force
    assert result.equilibrium.force_residual < 1e-3
    assert result.equilibrium.reaction_force == pytest.approx(expected, abs=1.0)
    arc = as_source.solve_by_lin_equations(scene, kinematics="arc")
    assert arc.support_reactions[:, :3].sum(axis=0) == pytest.approx(expected, abs=1e-6 * np.abs(result.load).max())
