"""The stability table: its cases, its verdicts, and a handful of its quickest rows (the command runs all)."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import body_checks, catalogue
from rollbench.compare.studies.extremes import static
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics import elastic, problem
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.section import screw_section

CASES = {c.name: c for c in static.cases()}
QUICK = (
    *("axial 0.01 N", "axial 1e+06 N", "clearance 50 um, 0.01 N", "preload 20 um, 0 N", "lateral 5000 N"),
    *("moment 50 N m", "offset 3 mm, 5000 N, no preload", "random +-20 um, preload 0 um, seed 1"),
    *("shaft x 0.001, contacts unchanged", "all moduli x 0.001", "r_G/r_B 1.00001, lateral", "3 balls", "lead 0 mm"),
    *("contact angle 5 deg", "one ball, 5000 N", "no support", "bearing under torque"),
    *("moment 0.01 N m, clearance, clamped", "offset -3 mm, away from one loose ball"),
    *("one ball, squeezed, free to move off",),
)


NOMINAL, GUESS, _ = static.SOURCE


def test_cases_cover_the_issue_with_scenes_that_a_file_may_describe_but_for_the_thin_tubes():
    every = static.cases()
    assert len({c.name for c in every}) == len(every) >= 80
    groups = "axial load, clearance, preload, random balls, shaft stiffness, moduli, conformity, lateral load, offset, "
    groups += "moment only, ball count, lead, contact angle, one ball, support"
    assert {c.group for c in every} >= set(groups.split(", "))
    refused = {c.name for c in every if list(body_checks.geometry_faults(c.scene))}
    assert refused == {f"shaft x {f:g}, contacts unchanged" for f in (1e-3, 1e-2, 1e-1)}


@pytest.mark.parametrize("factor", [1e-3, 1e-1, 1e1, 1e3])
def test_shaft_is_scaled_without_its_contacts(factor):
    base = catalogue.scene("lin-case1")
    scaled = static.shaft_scaled(base, factor)
    np.testing.assert_allclose(problem.nominal_hertz(scaled).C, problem.nominal_hertz(base).C, rtol=1e-12)
    before, after = screw_section(base), screw_section(scaled)
    assert pytest.approx(factor, rel=1e-9) == after.EA / before.EA
    assert pytest.approx(factor * (2.0 - factor) if factor < 1 else factor, rel=1e-9) == after.EI / before.EI


@pytest.mark.parametrize("formulation", [static.ENERGY, *static.BACKENDS])
@pytest.mark.parametrize("name", QUICK)
def test_ours_solves_or_names_the_mechanism(name, formulation):
    row = static.attempt(CASES[name], formulation)
    assert static.failures([row]) == []
    if row.status.startswith("not attempted"):
        assert formulation != static.ENERGY
        assert "leaves no wall" in row.status
        return
    if row.converged:
        assert row.residual <= max(1e-10, row.round_off_bound)
    else:
        assert "not held" in row.status
        assert row.residual is None


def test_source_needs_a_start_with_contact_agrees_but_beyond_the_arc_and_is_not_attempted_when_dense():
    case = CASES["axial 1000 N"]
    nominal, guess = static.attempt(case, NOMINAL), static.attempt(case, GUESS)
    beyond = static.attempt(CASES["r_G/r_B 1.00001, axial"], GUESS)
    assert nominal.status.startswith("singular Jacobian at iteration 1")
    assert nominal.difference_percent is None
    assert [guess.converged, beyond.converged] == [True, True]
    assert 0.0 < guess.difference_percent < 1e-6 < 1.0 < beyond.difference_percent
    assert "differ from the energy solver's" in beyond.reason
    case = CASES["300 balls"]
    row = static.attempt(case, NOMINAL)
    assert row.unknowns > static.DENSE_LIMIT
    assert row.status == f"not attempted: dense Jacobian of {row.unknowns} unknowns"
    assert static.dense_unknowns(case.scene) > row.unknowns  # a node at every contact has more


def test_false_claims_of_convergence_are_refused():
    good = solve_static(catalogue.scene("lin-case1"))
    assert static._fault(good) == ""
    assert "not finite" in static._fault(replace(good, load=np.full_like(good.load, np.nan)))
    for residual in (1e-9, float("nan")):
        assert "residual" in static._fault(replace(good, solver=replace(good.solver, residual=residual)))
    off = replace(good.equilibrium, moment_residual=2.0 * static.BALANCE)
    assert "do not balance" in static._fault(replace(good, equilibrium=off))


def test_failures_are_rows_of_ours_without_the_expected_end():
    held = static.attempt(CASES["no support"], static.ENERGY)
    assert held.status == held.expected != static.CONVERGED
    assert static.failures([held]) == []
    wrong = [replace(held, expected=static.CONVERGED), replace(held, status=static.CONVERGED, converged=True)]
    assert static.failures(wrong) == wrong
    assert static.failures([replace(w, formulation=NOMINAL) for w in wrong]) == []


def test_table_keeps_the_order_and_reports_progress(monkeypatch):
    seen: list[tuple[int, int, str]] = []
    names = ["moment 0.5 N m", "moment 50 N m", "moment 0.01 N m, clearance, clamped"]
    monkeypatch.setattr(static, "cases", lambda: [CASES[name] for name in names])
    rows = static.table(lambda done, total, name: seen.append((done, total, name)), n_jobs=1)
    assert [r.formulation for r in rows] == 3 * list(static.FORMULATIONS)
    assert [r.case for r in rows[:: len(static.FORMULATIONS)]] == names
    assert seen == [(i + 1, 3, name) for i, name in enumerate(names)]
    assert all(isinstance(r, static.Attempt) for r in rows)


@pytest.mark.parametrize("backend", ["lin-nut", "refined"])
def test_a_ball_that_moves_off_takes_few_steps(backend):
    """Under a contact that vanishes the stiffness of a step before it is too much: 994 steps, by one that was kept."""
    found = elastic.solve_elastic(CASES["one ball, squeezed, free to move off"].scene, backend=LADDER[backend])
    assert found.status == "converged"
    assert found.solver.iterations < 40
