"""Elastic bodies: stationarity of the solution, limits and equivalent forms, the contact law, rows and the shaft."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import relative, small_screw

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies.survey import SEED, random_screw_scene_text
from rollbench.lowfi.statics import response as model
from rollbench.lowfi.statics.contact_law import contact_law
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.parts import Load


def test_sides_left_out_that_touch_are_found():
    scene = small_screw(12, 2.5, force=(1900.0, 0.0, 4000.0))
    found, every = solve_elastic(scene), solve_elastic(scene, everything=True)
    assert found.converged
    assert any("solved again with all four" in text for text in found.solver.notes)
    assert (found.load[:, 1:3] > 0.0).any()
    assert relative(found.load, every.load) < 1e-8


#: C, e and h: both signs of each, with and without a place where the law goes on without them.
LAWS = [
    (1e-8, 0.0, 0.0),
    (1e-8, 3e-10, 0.0),
    (1e-8, -2e-10, 0.0),
    (1e-8, -2e-9, 0.0),
    (1e-8, 0.0, 2e-11),
    (1e-8, 0.0, -1e-10),
    (1e-8, -2e-10, 1e-12),
    (1e-8, -2e-9, 1e-9),
    (1e-8, 2e-10, -3e-11),
    (1e-8, -3e-10, -3e-11),
    (1e-8, 1e-9, -1e-17),
]


def turn(c, e, h):
    """Size F^(1/3) from which on a law goes on as half of Hertz's: least root of 4 h x^2 + 3 e x + C, or infinity."""
    roots = np.roots([4.0 * h, 3.0 * e, c]) if h or e else np.zeros(0)
    real = [float(r.real) for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0.0]
    return min(real, default=np.inf)


def law(delta, c, e, h):
    """Force, stiffness and energy of one contact."""
    return [float(x[0]) for x in contact_law(*np.array([[delta], [c], [e], [h]]))]


@pytest.mark.parametrize(("c", "e", "h"), LAWS)
def test_contact_law_inverts_its_formula_and_is_one_energy(c, e, h):
    """Slope, force and energy by finite differences and by the integral of the force, over the switch as well."""
    most = turn(c, e, h)
    edge = c * most**2 + e * most**3 + h * most**4 if most < 1e3 else 4e-6
    for force in np.geomspace(1e-6, 0.99 * min(most**3, 1e4), 12):
        delta = c * force ** (2 / 3) + e * force + h * force ** (4 / 3)
        assert law(delta, c, e, h)[0] == pytest.approx(force, rel=1e-10)
    if most < 1e3:
        force, _, _ = law(3.0 * edge, c, e, h)
        assert 0.5 * c * force ** (2 / 3) + edge - 0.5 * c * most**2 == pytest.approx(3.0 * edge, rel=1e-10, abs=0.0)

    for delta in edge * np.array([1e-3, 0.1, 0.5, 0.98, 1.02, 2.0, 10.0]):
        force, slope, energy = law(delta, c, e, h)
        step = 1e-5 * delta
        (f0, _, w0), (f1, _, w1) = (law(delta + s * step, c, e, h) for s in (-1.0, 1.0))
        assert (f1 - f0) / (2 * step) == pytest.approx(slope, rel=1e-7, abs=0.0)
        assert (w1 - w0) / (2 * step) == pytest.approx(force, rel=1e-7, abs=0.0)
        assert slope > 0.0
        node, weight = np.polynomial.legendre.leggauss(60)
        x = 0.5 * (node + 1.0)  # F grows as delta^(3/2): by x = sqrt(delta) the integrand is smooth
        forces = np.array([law(delta * y * y, c, e, h)[0] for y in x])
        assert delta * (weight * x) @ forces == pytest.approx(energy, rel=2e-5, abs=0.0)


def test_a_contact_beside_a_held_face_keeps_what_its_body_takes_from_it():
    """A drawn nut held at both faces, its first ball 1.03 radii from one: 219.2 N by 3D on level 1, 210.2 N where all
    negative compliance is cut away."""
    drawn = scene_file.scene_from_text(random_screw_scene_text(SEED, 2), "drawn.toml")
    result = run_model(drawn, "refined", ModelOptions(estimate_beam_mesh_error=False))
    said = [text for text in result.left_out if "negative compliance" in text]
    assert all(float(text.partition("up to ")[2].partition(" %")[0]) < 1.0 for text in said)
    assert result.load[0, 2] > 214.0


def test_limits_are_told():
    most = model.LARGEST
    with pytest.raises(ValueError, match=f"balls.count gives {most + 1} balls: .* at most {most};"):
        solve_elastic(small_screw(most + 1, most / 15.0))
    loose = replace(small_screw(), supports=(), loads=(Load(0.1, (0.0, 0.0, 0.0), (0.0, 0.0, 5.0)),))
    result = solve_elastic(loose)
    assert result.status.startswith("not held")
    scene = small_screw()
    with pytest.raises(ValueError, match="leaves no groove"):
        solve_elastic(replace(scene, screw=replace(scene.screw, outer_diameter=26e-3)))


def test_a_contact_beyond_the_land_near_a_face_is_refused():
    """The land cuts a groove off before a steep contact: beside a face there is no flank to press."""
    assert solve_elastic(small_screw(beta=np.radians(60.0))).converged
    with pytest.raises(ValueError, match="85 deg"):
        solve_elastic(small_screw(beta=np.radians(85.0)))
