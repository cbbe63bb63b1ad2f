"""The stability table: its cases, its verdicts, and a handful of its quickest rows (the command runs all)."""

from dataclasses import replace

import numpy as np
import pytest
from tests.campaign import check_axes

from rollbench.compare.cases.lin import newton
from rollbench.compare.studies import extremes
from rollbench.lowfi.statics.axis.solve import solve_assembly, solve_assembly_with_elastic_bodies

CASES = {c.name: c for c in extremes.hard_scenes()}
QUICK = (
    *("axial 0.01 N", "axial 1e+06 N", "clearance 50 um, 0.01 N", "preload 20 um, 0 N", "lateral 5000 N"),
    *("moment 50 N m", "offset 3 mm, 5000 N, no preload", "random +-20 um, preload 0 um, seed 1"),
    *("shaft x 0.001, contacts unchanged", "all moduli x 0.001", "r_G/r_B 1.00001, lateral", "3 balls", "lead 0 mm"),
    *("contact angle 5 deg", "one ball, 5000 N", "no support", "bearing under torque"),
    *("moment 0.01 N m, clearance, clamped", "offset -3 mm, away from one loose ball"),
    *("one ball, squeezed, free to move off", "polymer nut, lateral", "one ball 50 um too large, 5000 N"),
    *("4 balls, lateral", "6 m shaft, lateral"),
)
#: Axes: balls and rollers, rollers alone.
MIXED, ROLLERS = "axis of balls and rollers: ", "axis of rollers: "
AXES = (
    *(MIXED + x for x in ("across 1000 N", "-300 K", "4 balls in each set", "6 m shaft, across 1000 N", "100 rollers")),
    *(ROLLERS + x for x in ("across 100000 N", "-300 K", "crown of 0.1 m, across")),
)


NOMINAL, GUESS, _ = newton.FORMULATIONS


@pytest.mark.parametrize("formulation", [extremes.ENERGY, *extremes.BACKENDS])
@pytest.mark.parametrize("name", QUICK)
def test_ours_solves_or_names_the_mechanism(name, formulation):
    row = extremes.solve_hard_scene_by_formulation(CASES[name], formulation)
    assert extremes.unexpected_outcomes([row]) == []
    if row.status.startswith("not attempted"):
        assert formulation != extremes.ENERGY
        assert "leaves no wall" in row.status
        return
    if row.converged:
        assert row.residual <= max(1e-10, row.round_off_bound)
    else:
        assert "not held" in row.status
        assert row.residual is None


def test_source_needs_a_start_with_contact_agrees_but_beyond_the_arc_and_is_not_attempted_when_dense():
    nominal, guess = (extremes.solve_hard_scene_by_formulation(CASES["axial 1000 N"], of) for of in (NOMINAL, GUESS))
    beyond = extremes.solve_hard_scene_by_formulation(CASES["r_G/r_B 1.00001, axial"], GUESS)
    assert nominal.status.startswith("singular Jacobian at iteration 1")
    assert nominal.difference_percent is None
    assert [guess.converged, beyond.converged] == [True, True]
    assert 0.0 < guess.difference_percent < 1e-6 < 1.0 < beyond.difference_percent
    assert "differ from the energy solver's" in beyond.reason
    row = extremes.solve_hard_scene_by_formulation(CASES["300 balls"], NOMINAL)
    assert row.unknowns > newton.DENSE_LIMIT
    assert row.status == f"not attempted: dense Jacobian of {row.unknowns} unknowns"
    whole = newton.unknown_count_of_thesis_equations(CASES["300 balls"].scene)
    assert whole > row.unknowns, "a node at every contact has more"


def test_the_names_of_the_table_are_all_different():
    assert len(CASES) == len(extremes.hard_scenes()) > 150


@pytest.mark.parametrize("name", AXES)
def test_axes_are_judged_by_what_shares_no_code(name):
    case = CASES[name]
    ours = extremes.solve_hard_scene_by_formulation(case, extremes.ENERGY)
    assert extremes.unexpected_outcomes([ours]) == []
    assert ours.converged
    assert check_axes.faults(case.scene, solve_assembly(case.scene)) == ""


def test_a_row_of_rollers_that_is_pulled_out_is_named_and_one_that_is_pushed_in_holds():
    pair = [CASES[f"one row of rollers: axial {x} N"] for x in ("1000", "-1000")]
    rows = [extremes.solve_hard_scene_by_formulation(case, extremes.ENERGY) for case in pair]
    assert extremes.unexpected_outcomes(rows) == []
    assert [check_axes.proven(case.scene, False) for case in pair] == [True, False]


def test_other_loads_than_the_law_of_a_slice_are_found():
    case = CASES[MIXED + "across 1000 N"]
    found = solve_assembly(case.scene)
    row = found.sets[3]
    # round-off by the order of sums, which differs with what ran before: 0.7e-12 to 1.5e-12
    assert extremes.roller_slice_law_residual(row, found) < 5e-12
    lines = row.line_loads.copy()
    lines[0, 0] *= 1.0 + 1e-6
    assert extremes.roller_slice_law_residual(replace(row, line_loads=lines), found) > extremes.SLICES
    tilted = found.centreline.copy()
    tilted[int(np.abs(found.centreline_z - row.of.position).argmin()), 0] += 1e-9
    assert extremes.roller_slice_law_residual(row, replace(found, centreline=tilted)) > extremes.SLICES


def test_what_is_cut_away_of_elastic_bodies_leaves_rollers_on_the_same_shaft_in_balance():
    axis = CASES[MIXED + "axial 3000 N"].scene
    found = solve_assembly_with_elastic_bodies(axis)
    assert found.status == "converged"
    assert max(found.equilibrium.force_residual, found.equilibrium.moment_residual) < 1e-9
