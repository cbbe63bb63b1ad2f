"""The stability table: its cases, its verdicts, and a handful of its quickest rows (the command runs all)."""

import pytest

from rollbench.compare.studies import extremes

CASES = {c.name: c for c in extremes.cases()}
QUICK = (
    *("axial 0.01 N", "axial 1e+06 N", "clearance 50 um, 0.01 N", "preload 20 um, 0 N", "lateral 5000 N"),
    *("moment 50 N m", "offset 3 mm, 5000 N, no preload", "random +-20 um, preload 0 um, seed 1"),
    *("shaft x 0.001, contacts unchanged", "all moduli x 0.001", "r_G/r_B 1.00001, lateral", "3 balls", "lead 0 mm"),
    *("contact angle 5 deg", "one ball, 5000 N", "no support", "bearing under torque"),
    *("moment 0.01 N m, clearance, clamped", "offset -3 mm, away from one loose ball"),
    *("one ball, squeezed, free to move off",),
)


NOMINAL, GUESS, _ = extremes.SOURCE


@pytest.mark.parametrize("formulation", [extremes.ENERGY, *extremes.BACKENDS])
@pytest.mark.parametrize("name", QUICK)
def test_ours_solves_or_names_the_mechanism(name, formulation):
    row = extremes.attempt(CASES[name], formulation)
    assert extremes.failures([row]) == []
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
    case = CASES["axial 1000 N"]
    nominal, guess = extremes.attempt(case, NOMINAL), extremes.attempt(case, GUESS)
    beyond = extremes.attempt(CASES["r_G/r_B 1.00001, axial"], GUESS)
    assert nominal.status.startswith("singular Jacobian at iteration 1")
    assert nominal.difference_percent is None
    assert [guess.converged, beyond.converged] == [True, True]
    assert 0.0 < guess.difference_percent < 1e-6 < 1.0 < beyond.difference_percent
    assert "differ from the energy solver's" in beyond.reason
    case = CASES["300 balls"]
    row = extremes.attempt(case, NOMINAL)
    assert row.unknowns > extremes.DENSE_LIMIT
    assert row.status == f"not attempted: dense Jacobian of {row.unknowns} unknowns"
    assert extremes.dense_unknowns(case.scene) > row.unknowns  # a node at every contact has more
