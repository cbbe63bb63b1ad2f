"""Overall coefficients of calculators in place of that of sliding contacts: a warning that says what they would mean."""

from math import atan, pi, tan

import pytest

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.rating.catalogue_checks import efficiency_by_overall_friction, warn_of_overall_friction_coefficient
from rollbench.meshes.parts import Friction, Track

TRACK = Track(16.5e-3, 20e-3, pi / 4.0)


def test_the_efficiency_of_a_calculator() -> None:
    """Pitch circle 33 mm, lead 20 mm, f 0.01: a public sheet has 0.9484; without friction nothing is lost."""
    assert efficiency_by_overall_friction(TRACK, 0.01) == pytest.approx(0.9484, abs=1e-3)
    phi = atan(20.0 / (33.0 * pi))
    assert efficiency_by_overall_friction(TRACK, 0.01) == pytest.approx(tan(phi) / tan(phi + 0.01), rel=1e-5)
    assert efficiency_by_overall_friction(TRACK, 0.0) == 1.0


LOW = [((0.01, 0.01), 1), ((0.003, 0.003), 1), ((0.1, 0.1), 0), ((0.01, 0.05), 0)]


@pytest.mark.parametrize(("coefficients", "warned"), LOW)
def test_low_coefficients_are_met_by_a_warning(coefficients: tuple[float, float], warned: int) -> None:
    found = warn_of_overall_friction_coefficient(TRACK, Friction(*coefficients))
    assert len(found) == warned
    assert all(w.brief for w in found)


def test_a_ring_is_warned_of_without_an_efficiency() -> None:
    (found,) = warn_of_overall_friction_coefficient(Track(20e-3, 0.0, 0.0), Friction(0.0015, 0.0015))
    assert "efficiency" not in found


@pytest.mark.parametrize("given", ["0.1", "0.01"])
def test_the_line_above_the_answers_says_what_the_coefficient_would_mean(tmp_path, command, given: str) -> None:
    text = catalogue.shipped_scene_text("lin-case1").replace("coefficient = 0.1", f"coefficient = {given}")
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    head = " ".join(command.said("solve", tmp_path / "my.toml", "--model", "lin").split("quantity ")[0].split())
    assert ("overall coefficients" in head, "94.9 %" in head) == (given == "0.01", given == "0.01")
    assert "outside what the models mean" not in head
