"""A tapered roller between its races in 3D: meshes, plane strain in closed form, Hertz's line contact, balance."""

import numpy as np
import pytest
from scipy.special import j1

from rollbench.hifi.contact import roller
from rollbench.hifi.elements import forms
from rollbench.meshes import roller_body
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import Material

pytestmark = pytest.mark.xdist_group("a pressed roller")

E, NU = 207e9, 0.3
#: Radius and half length of a roller, depth of a ring [m]; half-width of a contact.
R, HALF, DEPTH, B = 4e-3, 15e-3, 5e-3, 0.06e-3
ZONE = roller_body.RollerContactZone(1.6 * B, 6, 0.9)
#: Nearly parallel cones.
ANGLE = np.radians(0.2)
MIDDLE = R / np.sin(ANGLE)
LINES = MIDDLE + HALF * np.array([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0])


ENDS = LINES[0], LINES[-1]


def cylinder():
    flat = roller_body.mesh_roller_or_raceway_section(ZONE, R, R, is_roller=True)
    place = roller_body.roller_point_map(R, ANGLE, np.zeros_like)
    return roller_body.build_extruded_roller_body(flat, ZONE, LINES, ENDS, place, is_roller=True)


def slab(count):
    """Return a race so far from the apex that it is nearly flat, and its half width."""
    angle = np.radians(30.0)
    width = MIDDLE * np.sin(angle) * np.sin(np.pi / count)
    flat = roller_body.mesh_roller_or_raceway_section(ZONE, width, DEPTH, is_roller=False)
    place = roller_body.raceway_point_map(MIDDLE, angle, 1.0)
    return roller_body.build_extruded_roller_body(flat, ZONE, LINES, ENDS, place, mirrored=True), width


def middle_approach(body, matrix, load):
    """Displacement into a body of the middle of its contact line under Hertz's pressure of a load per length, b = B."""
    areas = np.asarray(forms.pressure_function_integrals(body.mesh, body.contact_nodes.ravel()).sum(axis=1))
    hertz = np.sqrt(np.maximum(1.0 - (body.distances_from_contact_line / B) ** 2, 0.0))
    forces = areas.reshape(body.contact_nodes.shape) * hertz
    forces *= 0.5 * load * 2.0 * HALF / forces.sum()
    middle = len(body.distances_from_apex) // 2 * len(body.distances_from_contact_line)
    return float((matrix @ forces.ravel())[middle])


def test_meshes_have_the_volumes_of_their_bodies():
    body, (ring, width) = cylinder(), slab(1000)
    cone = np.pi / 12.0 * np.tan(ANGLE) ** 2 * (LINES[-1] ** 3 - LINES[0] ** 3) * np.cos(ANGLE) ** 3
    volume = forms.nodal_volume_form()
    assert volume.assemble(forms.cell_basis(body.mesh)).sum() == pytest.approx(cone, rel=1e-3)
    wider = 1.0 + 0.5 * DEPTH / (MIDDLE * np.tan(np.radians(30.0)))  # in the middle of its depth
    assert volume.assemble(forms.cell_basis(ring.mesh)).sum() == pytest.approx(2.0 * HALF * width * DEPTH * wider, rel=1e-3)
    assert forms.nodal_areas(body.mesh, "contact").sum() == pytest.approx(2.0 * HALF * ZONE.half_width, rel=1e-3)


def test_half_a_roller_is_compressed_as_in_closed_form():
    """Johnson (1985), 5.57, and 2 nu^2 q/(pi E) for free ends: plane strain's axial force 2 nu q R is taken off."""
    body, q = cylinder(), 1e5
    S = roller.roller_compliance(body, E, NU, symmetric_loads=True)
    exact = q * (1.0 - NU**2) / (np.pi * E) * (2.0 * np.log(4.0 * R / B) - 1.0) + 2.0 * NU**2 * q / (np.pi * E)
    assert middle_approach(body, S, q) == pytest.approx(exact, rel=0.01)


def test_race_sinks_as_a_layer_on_a_rigid_base():
    """Plane strain of a layer, bonded below, its sides planes of symmetry: a series of cosines in closed form."""
    q, count = 1e5, 2000
    body, width = slab(count)
    C = roller.race_compliance(body, E, NU, np.pi / count)
    mean = q / (2.0 * width) * DEPTH * (1.0 + NU) * (1.0 - 2.0 * NU) / ((1.0 - NU) * E)
    k = np.pi * np.arange(1, 40_000) / width
    kd = np.minimum(k * DEPTH, 300.0)
    below = (3.0 - 4.0 * NU) * np.cosh(2.0 * kd) + 5.0 - 12.0 * NU + 8.0 * NU**2 + 2.0 * kd**2
    green = 2.0 * (1.0 - NU**2) / (E * k) * ((3.0 - 4.0 * NU) * np.sinh(2.0 * kd) - 2.0 * kd) / below
    waves = q / width * 2.0 * j1(k * B) / (k * B)
    assert middle_approach(body, C, q) == pytest.approx(mean + float(green @ waves), rel=0.01)


ROW = RollerRow(16, 8.38e-3, 12.4e-3, np.radians(30.8), np.radians(4.0), 5e-3, Material(E, NU), edge_radius=1e-3)
LOAD = 1250.0


@pytest.fixture(scope="module")
def pressed():
    bodies = roller.condense_roller(ROW, roller.LEVELS[1], LOAD)
    return {share: roller.press_roller_between_races(bodies, share * LOAD) for share in (1.0, 0.7, 0.25)}


@pytest.mark.slow
def test_middle_pressure_is_that_of_line_contact(pressed):
    """Within 1 %, and the contact carries the load; pressures at the ends are finite and the largest."""
    s = pressed[1.0]
    radius, cone, cup = np.tan(np.radians([4.0, 22.8, 30.8])) * 0.5 * ROW.diameter / np.sin(np.radians(4.0))
    curved = np.array([1.0 / radius - 1.0 / cup, 1.0 / radius + 1.0 / cone])
    hertz = np.sqrt(s.line_load_at_middle * curved * E / (1.0 - NU**2) / 2.0 / np.pi)
    assert s.largest_pressure_at_middle == pytest.approx(hertz, rel=0.01)
    assert s.load_imbalance < 1e-4
    assert np.all(s.pressures.max(axis=(1, 2)) > 1.5 * s.largest_pressure_at_middle)


@pytest.mark.slow
def test_approach_over_line_load_has_the_slope_of_two_line_contacts(pressed):
    """Of plane strain delta/q = g - S ln q, with S = 4 (1 - nu^2)/(pi E) whatever the bodies are."""
    full, quarter = (pressed[share] for share in (1.0, 0.25))
    q = [float(state.line_load_at_middle.mean()) for state in (full, quarter)]
    compliance = full.approach / q[0], quarter.approach / q[1]
    slope = (compliance[0] - compliance[1]) / np.log(q[0] / q[1])
    assert slope == pytest.approx(-4.0 * (1.0 - NU**2) / (np.pi * E), rel=0.05)


@pytest.mark.slow
def test_stiffness_is_the_slope_of_load_over_approach(pressed):
    low, high = pressed[0.7], pressed[1.0]
    secant = (high.race_force - low.race_force) / (high.approach - low.approach)
    assert low.stiffness < secant < high.stiffness
