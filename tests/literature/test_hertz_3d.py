"""Hertz: the closed form against published numbers and other integrals, and the 3D reference against the closed form.

Numbers of jobs A and B: ball of radius 2.778 mm, E = 210 GPa, nu = 0.28, 225 N, on a flat and in a groove of radius
3.254 mm, convex along it with 20.56 mm; elliptic-integral Hertz, six digits.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe, ellipk
from tests.hertz_studies import GROUP, study
from tests.section_items import drawn, figures, tables

from rollbench.compare.sections import verification
from rollbench.hifi.contact.block import JOBS, boussinesq_displacements
from rollbench.hifi.contact.hertz import THINNEST, solve_hertz

pytestmark = pytest.mark.xdist_group(GROUP)

#: approach [um], semi-axes [mm], pole pressure [MPa]
EXACT = {"A": (9.24316, 0.160242, 0.160242, 4183.80), "B": (6.48391, 0.401384, 0.104759, 2554.89)}


@pytest.mark.parametrize("closer", [1.0 - 1e-3, 1.0 + 1e-3])
def test_the_closed_form_ends_where_an_ellipse_is_too_thin(closer):
    """Long ellipse of b/a = r: curvatures in the ratio r^2 (ln(4/r) - 1) along and across (Johnson 4.28 for small r)."""
    curvatures = THINNEST**2 * (np.log(4.0 / THINNEST) - 1.0) * closer
    if closer > 1.0:
        found = solve_hertz(100.0, 1e-3 / curvatures, 1e-3, 210e9, 0.3)
        assert found.semi_y / found.semi_x == pytest.approx(THINNEST, rel=1e-3)
    else:
        with pytest.raises(ValueError, match="thinner than"):
            solve_hertz(100.0, 1e-3 / curvatures, 1e-3, 210e9, 0.3)


@pytest.mark.parametrize("name", EXACT)
def test_closed_form_gives_the_published_numbers(name):
    exact = JOBS[name].hertz_solution
    found = (1e6 * exact.approach, 1e3 * exact.semi_x, 1e3 * exact.semi_y, 1e-6 * exact.pole_pressure)
    assert found == pytest.approx(EXACT[name], rel=2e-6)


@pytest.mark.parametrize("ratio", [1.0, 1.3, 8.0, 300.0])
def test_closed_form_satisfies_johnsons_equations_with_library_integrals(ratio):
    young, nu, load, short = 210e9, 0.3, 100.0, 2e-3
    s = solve_hertz(load, ratio * short, short, young, nu)
    modulus = young / (2.0 * (1.0 - nu**2))
    assert load == pytest.approx(2.0 * np.pi / 3.0 * s.pole_pressure * s.semi_x * s.semi_y, rel=1e-13)
    m = 1.0 - (s.semi_y / s.semi_x) ** 2
    k, e = ellipk(m), ellipe(m)
    assert s.approach == pytest.approx(s.pole_pressure * s.semi_y * k / modulus, rel=1e-11)
    if ratio > 1.0:  # Johnson 4.26a, b: curvatures along x and y
        scale = s.pole_pressure * s.semi_y / (modulus * m * s.semi_x**2)
        assert 0.5 / (ratio * short) == pytest.approx(scale * (k - e), rel=1e-8)
        assert 0.5 / short == pytest.approx(scale * (e / (1.0 - m) - k), rel=1e-8)


def test_approach_is_the_potential_of_the_pressure_at_the_pole():
    s, job = JOBS["B"].hertz_solution, JOBS["B"]
    theta = 2.0 * np.pi * (np.arange(400) + 0.5) / 400
    radius = 1.0 / np.sqrt((np.cos(theta) / s.semi_x) ** 2 + (np.sin(theta) / s.semi_y) ** 2)
    modulus = job.young / (2.0 * (1.0 - job.poisson**2))
    assert s.pole_pressure / (4.0 * modulus) * 2.0 * np.pi * radius.mean() == pytest.approx(s.approach, rel=1e-12)


def test_order_of_the_radii_does_not_matter_and_wrong_input_is_refused():
    one, other = solve_hertz(50.0, 1e-3, 4e-3, 2e11, 0.3), solve_hertz(50.0, 4e-3, 1e-3, 2e11, 0.3)
    assert (one.approach, one.semi_x, one.semi_y) == (other.approach, other.semi_y, other.semi_x)
    assert one.semi_y > one.semi_x
    with pytest.raises(ValueError, match="must be > 0"):
        solve_hertz(50.0, -1e-3, 4e-3, 2e11, 0.3)
    with pytest.raises(ValueError, match="line contact"):
        solve_hertz(50.0, 1e6, 1e-3, 2e11, 0.3)


def test_boussinesqs_field_carries_one_newton_through_every_hemisphere():
    """Traction by numerical differentiation, integrated over a hemisphere: the load, and no side force."""
    young, nu, step = 1.0, 0.28, 1e-5
    lam, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    nodes, weights = np.polynomial.legendre.leggauss(24)
    phi, c = (x.ravel() for x in np.meshgrid(2.0 * np.pi * np.arange(16) / 16, 0.5 * (nodes + 1.0)))
    s, weight = np.sqrt(1.0 - c**2), np.repeat(0.5 * weights, 16) * 2.0 * np.pi / 16
    normal = np.column_stack([s * np.cos(phi), s * np.sin(phi), c])

    def moved(places):
        return boussinesq_displacements(places, np.zeros((1, 2)), young, nu)[..., 0]

    slope = np.stack([(moved(normal + d) - moved(normal - d)) / (2 * step) for d in step * np.eye(3)], axis=2)  # u_i,j
    strain = 0.5 * (slope + slope.transpose(0, 2, 1))
    stress = 2 * mu * strain + lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    force = np.einsum("n,nij,nj->i", weight, stress, normal)
    np.testing.assert_allclose(force, [0.0, 0.0, -1.0], atol=1e-7)
    (surface,) = moved(np.array([[3.0, 4.0, 0.0]]))
    assert surface[2] == pytest.approx((1 - nu**2) / (np.pi * young * 5.0))
    assert surface[0] < 0.0  # the surface is drawn towards the load


@pytest.mark.parametrize("aim", [0.94, 1.0, 1.06])
@pytest.mark.parametrize("name", JOBS)
def test_production_mesh_meets_its_targets_wherever_the_contacts_edge_falls(name, aim):
    run = study(JOBS[name], "Q2", 4.0, mesh_scale=aim)
    exact = run.hertz_solution
    assert run.approach == pytest.approx(exact.approach, rel=3e-3)
    assert (run.semi_x, run.semi_y) == pytest.approx((exact.semi_x, exact.semi_y), rel=5e-3)
    assert (run.pole_pressure, run.fitted_pole_pressure) == pytest.approx(2 * (exact.pole_pressure,), rel=1e-2)


def test_section_says_from_the_data_whether_the_targets_are_met(monkeypatch):
    monkeypatch.setattr(verification, "solve_block", study)
    section = verification.hertz_section(verification.compute_hertz_contacts(lambda _: None, {"Q1": (2,), "Q2": (4,)}))
    verdicts = section.items[1].paragraphs
    assert sum("All targets are met" in line for line in verdicts) == 2
    assert sum("size of Lin" in line for line in verdicts) == 2
    rows = tables(section)["verification-errors"].rows
    assert [(row["contact_a_or_b"], row["cells_across_b"]) for row in rows[:2]] == [("A", 2.0), ("A", 4.0)]
    by_hand = 100.0 * (study(JOBS["A"], "Q2", 4.0).approach / JOBS["A"].hertz_solution.approach - 1.0)
    assert rows[1]["error_of", "approach"] == pytest.approx(by_hand, rel=1e-6)
    drawn(figures(section))


def test_section_admits_a_target_that_is_missed():
    coarse = replace(study(JOBS["A"], "Q2", 2.0), b_over_h=4.0)
    missed = [verification.hertz_computation_with_errors("27-node hexahedra", coarse)]
    assert "NOT MET: approach, semi-axes, pole pressure" in verification.error_target_sentences(missed)[0]
    rows = verification.rows_of_computed_and_hertz_values(missed)
    assert [row["error_within_target"] for row in rows] == ["NO"] * 4
