"""The source's own formulation: its Jacobian, and its agreement with the energy solver."""

from dataclasses import replace

import numpy as np
import pytest
from tests.dense_beam import screw_beam_stiffness_matrix
from tests.helpers import FLANK_ERRORS, NO_PROFILES, four_flank_problem, relative, small_screw, solved, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.as_source import newton as as_source
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors

CASES = ("lin-case1", "lin-case2", "lin-case3", "lin-case3-offset")


def system_of(scene, kinematics):
    layout, problem = ball_layout(scene), four_flank_problem(scene)
    free = np.concatenate([np.arange(6 * layout.z.size), 6 * layout.z.size + np.flatnonzero(~problem.fixed.ravel())])
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    return as_source.LinEquations(problem, kinematics, screw_beam_stiffness_matrix(problem), free, axes)


@pytest.mark.parametrize("errors", [None, FLANK_ERRORS], ids=["exact", "errors"])
@pytest.mark.parametrize("partition", ["nodal", "source"])
@pytest.mark.parametrize("kinematics", ["arc", "source"])
def test_jacobian(kinematics, partition, errors):
    """Central differences, each column on the scale of its unknown, at a state with three and four contacts a ball."""
    scene = small_screw(oversize=5e-6, partition=partition)
    if errors:
        scene = replace(scene, errors=replace(errors, balls=BallErrors(oversize=5e-6)))
    system = system_of(scene, kinematics)
    count, size = 6, 36 + 6 * system.problem.nodes.size
    rng = np.random.default_rng(3)
    unit = np.concatenate(  # a micrometre, and the angle that shifts a contact or the pitch circle by as much
        [np.full(12, 1e-6), np.full(24, 1e-2), np.tile([1e-6] * 3 + [5e-5] * 3, system.problem.nodes.size)]
    )
    x = as_source.newton_start_values(system, "nominal", 1.0) + unit * rng.normal(0.0, 0.3, size)
    load = rng.normal(0.0, 10.0, size - 36)
    _, jacobian, forces = as_source.equations_and_jacobian(system, x, load)
    assert (forces > 0.0).sum() >= 3 * count
    for k in range(size):
        step = np.zeros(size)
        step[k] = 1e-4 * unit[k]
        high, low = (as_source.equations_and_jacobian(system, x + sign * step, load)[0] for sign in (1, -1))
        found, expected = jacobian[:, k] * unit[k], (high - low) / 2e-4
        for rows in (slice(12), slice(12, 36), slice(36, None)):  # balls, contact conditions, screw
            scale = np.abs(jacobian[rows] * unit).max()
            assert np.abs(found[rows] - expected[rows]).max() < 1e-6 * scale


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
