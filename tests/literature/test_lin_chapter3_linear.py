"""Printed numbers and claims of Lin (2019), section 3.3: each entry is data, each is a test."""

from functools import cache
from math import degrees, radians

import numpy as np
import pytest

from compare.evidence import source_cases
from compare.printed.printed_data import Printed, load_table
from lowfi.friction.linear.analytic import velocity_deviation
from lowfi.friction.linear.loads import Loads
from lowfi.friction.linear.pair import PairMaps, PairResult, maps, pair_formulas, pair_state, solve_pair

TABLES = ("lin-3.3", "lin-3.4", "lin-3.5")
ROWS: dict[str, Printed] = {f"{r.table}:{r.key}": r for t in TABLES for r in load_table(t)}
SCENE = source_cases.linear()
BEARING, VERTICAL, SIDE, THETA = SCENE.bearing, SCENE.vertical, float(SCENE.side[0]), SCENE.deviation


@cache
def numerical(mated: bool, theta: float = THETA, loads: Loads = "balanced") -> PairResult:
    return solve_pair(BEARING, theta, SIDE, VERTICAL, mated=mated, loads=loads)


@cache
def study() -> PairMaps:
    return maps(BEARING, np.radians(np.linspace(-3.0, 3.0, 7)), np.linspace(-0.6, 0.6, 7), VERTICAL, source_cases.k_f())


def formula_deviation(mated: bool) -> np.ndarray:
    angles, loads = pair_state(BEARING, THETA, SIDE, VERTICAL, mated=mated, loads="diagonal")
    return velocity_deviation(BEARING.contact_angle, angles - BEARING.contact_angle, loads[:, 0], loads[:, 1])


def number(key: str) -> float:
    """Our value of a printed number, in the unit printed there."""
    table, name = key.split(":")
    printed = {r.key: r.value for r in load_table("lin-3.5")}
    given = {
        "ball_radius": BEARING.ball_radius * 1e3,
        "conformity": BEARING.conformity,
        "psi": BEARING.psi(),
        "vertical": VERTICAL,
        "speed": BEARING.speed * 1e3,
        "mu": BEARING.mu,
        "young": BEARING.young,
        "poisson": BEARING.poisson,
        "contact_angle": degrees(BEARING.contact_angle),
        "yaw": abs(SIDE) * VERTICAL * 2.0 * BEARING.ball_radius * 1e3,
    }
    if name in given:
        return given[name]
    if name == "worst_ratio":
        return 100.0 * numerical(False, radians(3.0)).rubbing_ratio
    if name == "error_numerical":
        return 100.0 * (printed["a_force_numerical"] / printed["a_force_ansys"] - 1.0)
    mated = name.startswith("b_")
    if table == "lin-3.4":
        ball = int(name[5]) - 1
        found = numerical(mated).free.deviation if name.endswith("numerical") else formula_deviation(mated)
        return 100.0 * float(found[ball])
    if name.endswith("numerical"):
        return numerical(mated).force
    return pair_formulas(BEARING, THETA, SIDE, VERTICAL, source_cases.k_f(), mated=mated)[1]


NUMBERS = [k for k, r in ROWS.items() if r.value is not None and r.cls != "open"]


@pytest.mark.parametrize("key", NUMBERS)
def test_printed_number(key: str) -> None:
    row, ours = ROWS[key], number(key)
    if row.cls == "band":
        assert row.low <= ours <= row.high, f"{row.label}: {ours}"
    else:
        assert ours == pytest.approx(row.value, abs=row.tolerance), row.label


def test_open_numbers_are_only_shown() -> None:
    assert {k.split(":")[1] for k, r in ROWS.items() if r.cls == "open"} == {
        "a_force_ansys",
        "b_force_ansys",
        "a_time_numerical",
        "a_time_analytic",
        "a_time_ansys",
        "b_time_numerical",
        "b_time_analytic",
        "b_time_ansys",
    }


def test_claim_increase_grows() -> None:
    """lin-3.3:worst_increase, with the force: along theta and along rho, where balls touch."""
    m = study()
    touching = m.ratio[4:, 2::-1]  # theta = 1, 2, 3 degrees; rho = -0.2, -0.4, -0.6
    for field in (touching, m.force[4:, 2::-1]):
        assert np.all(np.diff(field, axis=0) > 0.0)
        assert np.all(np.diff(field, axis=1) > 0.0)
    assert m.ratio.max() == pytest.approx(touching[-1, -1], rel=1e-9)
    assert m.ratio.max() - 1.0 > 0.8


def test_claim_models_agree_away_from_the_corners() -> None:
    """lin-3.3:maps_agree: within a tenth of the largest value for half the range, a good deal more at the corners."""
    m = study()
    inner = (slice(2, 5), slice(2, 5))
    for ours, error in [(m.difference, m.difference_error), (m.force, m.force_error), (m.ratio - 1.0, m.ratio_error)]:
        assert np.abs(error[inner]).max() < 0.02 * np.abs(ours).max()
        assert np.abs(error).max() > 3.0 * np.abs(error[inner]).max()
        assert np.abs(error).max() < 0.25 * np.abs(ours).max()


def test_claim_contact_only_where_balls_close_in() -> None:
    """lin-3.3:sign_region."""
    m = study()
    assert m.failures == 0
    closing = m.difference > 1e-9
    assert np.all(m.force[closing] > 0.0)
    np.testing.assert_allclose(m.force[~closing], 0.0, atol=1e-8)


def test_claim_formula_is_within_six_per_cent_of_ansys() -> None:
    """lin-3.5:error_analytic."""
    ansys = ROWS["lin-3.5:a_force_ansys"].value
    assert abs(number("lin-3.5:a_force_analytic") / ansys - 1.0) < 0.06


def test_spread_of_what_the_text_leaves_open() -> None:
    """The band of the numerical force in lin-3.5 and the remarks in lin-3.3, lin-3.4, by the readings they name."""
    found = {loads: numerical(False, THETA, loads).force for loads in ("diagonal", "balanced", "elastic")}
    assert found == {
        "diagonal": pytest.approx(3.98, abs=5e-3),
        "balanced": pytest.approx(4.065, abs=5e-3),
        "elastic": pytest.approx(4.042, abs=5e-3),
    }
    equal = numerical(False, THETA, "diagonal").free.deviation
    assert equal[0] == pytest.approx(-equal[1], rel=1e-9)
    assert 100.0 * equal[0] == pytest.approx(0.81, abs=5e-3)
    assert 100.0 * numerical(False, radians(3.0), "elastic").rubbing_ratio == pytest.approx(185.3, abs=0.05)
    assert 100.0 * numerical(False, radians(3.0)).friction_increase == pytest.approx(89.5, abs=0.5)
