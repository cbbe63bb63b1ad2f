"""Printed numbers and claims of Lin (2019), section 3.3: each entry is data, each is a test."""

from math import radians

import numpy as np
import pytest
from tests.evidence_study import GROUP
from tests.sources.entries import check, keys

from rollbench.compare.cases.lin.evidence.rotary_linear import ball_force_and_loss_over_grid, solve_linear_ball_pair
from rollbench.compare.printed import load_printed_table

pytestmark = pytest.mark.xdist_group(GROUP)

TABLES = ("lin-3.3", "lin-3.4", "lin-3.5")


@pytest.mark.parametrize("key", keys(*TABLES))
def test_entry(key: str) -> None:
    check(key)


def test_open_numbers_are_only_shown() -> None:
    shown = ("force_ansys", "time_numerical", "time_analytic", "time_ansys")
    found = {r.key for name in TABLES for r in load_printed_table(name) if r.entry_class == "open"}
    assert found == {"elements_ansys", *(f"{case}_{key}" for case in "ab" for key in shown)}


def test_claim_increase_grows() -> None:
    """lin-3.3:worst_increase, with the force: along theta and along rho, where balls touch."""
    _, force, ratio = ball_force_and_loss_over_grid()[0]
    touching = ratio[4:, 2::-1]  # theta = 1, 2, 3 degrees; rho = -0.2, -0.4, -0.6
    for field in (touching, force[4:, 2::-1]):
        assert np.all(np.diff(field, axis=0) > 0.0)
        assert np.all(np.diff(field, axis=1) > 0.0)
    assert ratio.max() == pytest.approx(touching[-1, -1], rel=1e-9)
    assert ratio.max() - 1.0 > 0.8


def test_claim_models_agree_away_from_the_corners() -> None:
    """lin-3.3:maps_agree: within a tenth of the largest value for half the range, a good deal more at the corners."""
    numerical, formula = ball_force_and_loss_over_grid()
    inner = (slice(2, 5), slice(2, 5))
    for ours, error in zip(numerical - np.array([0.0, 0.0, 1.0])[:, None, None], formula - numerical, strict=True):
        assert np.abs(error[inner]).max() < 0.02 * np.abs(ours).max()
        assert np.abs(error).max() > 3.0 * np.abs(error[inner]).max()
        assert np.abs(error).max() < 0.25 * np.abs(ours).max()


def test_claim_contact_only_where_balls_close_in() -> None:
    """lin-3.3:sign_region."""
    difference, force, _ = ball_force_and_loss_over_grid()[0]
    closing = difference > 1e-9
    assert np.isfinite(force).all()
    assert np.all(force[closing] > 0.0)
    np.testing.assert_allclose(force[~closing], 0.0, atol=1e-8)


def test_spread_of_what_the_text_leaves_open() -> None:
    """The band of the numerical force in lin-3.5 and the remarks in lin-3.3, lin-3.4, by the readings they name."""
    forces = {"diagonal": 3.98, "balanced": 4.065, "elastic": 4.042}
    found = {loads: solve_linear_ball_pair(loads=loads).ball_to_ball_force for loads in forces}
    assert found == pytest.approx(forces, abs=5e-3)
    equal = solve_linear_ball_pair(loads="diagonal").velocity_deviation
    assert equal[0] == pytest.approx(-equal[1], rel=1e-9)
    assert 100.0 * equal[0] == pytest.approx(0.81, abs=5e-3)
    elastic = solve_linear_ball_pair(radians(3.0), "elastic")
    assert 100.0 * elastic.groove_and_ball_loss_ratio == pytest.approx(185.3, abs=0.05)
    worst = solve_linear_ball_pair(radians(3.0))
    assert 100.0 * (worst.touching.loss / worst.apart.loss - 1.0) == pytest.approx(89.5, abs=0.5)
