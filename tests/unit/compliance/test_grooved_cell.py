"""Half a lead of a grooved body: plain cells exactly, convergence, bounds, and the screw homogenised in 3D."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.shaft.section import stiffness_of_grooved_shaft
from rollbench.lowfi.compliance import parts, tube
from rollbench.lowfi.compliance.fourier import BodyOfRevolution, tube_grid
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.section import tube_section

SCENE = catalogue.scene("lin-case1")
GEOMETRY = parts.reduce_to_compliance_geometry(SCENE)
MAP, STEEL = GrooveMap.from_scene(SCENE), SCENE.screw.material
LAND = 16e-3
KINDS = {"axial": "EA", "torsion": "GJ", "bending": "EI"}


def groove(m=MAP, land=LAND, bore=0.0):
    """Half a groove of a screw."""
    return tube.HalfGroove(m, land, bore, True, np.pi * abs(m.rg) / m.starts, STEEL)


ROOT = float(groove().profile_points(17)[0][0])


def constants(grid):
    body = BodyOfRevolution(grid, STEEL)
    return np.array([tube.solve_half_lead_under_unit_motion(body, kind)[0] * float(grid.z[-1, 0]) for kind in KINDS])


def of_screw(**dimensions):
    return tube.grooved_beam_section(groove(**dimensions))


def of_section(section):
    return np.array([getattr(section, name) for name in KINDS.values()])


@pytest.mark.parametrize("bore", [0.0, 5e-3, 14e-3])
def test_plain_cell_is_exact(bore):
    found = constants(tube_grid(np.linspace(bore, 16e-3, 4), np.linspace(0.0, 10e-3, 3)))
    np.testing.assert_allclose(found, of_section(tube_section(32e-3, 2 * bore, STEEL)), rtol=1e-10)


@pytest.mark.parametrize("screw", [True, False], ids=["screw", "nut"])
def test_refinement(screw):
    flank = parts.half_groove_of_body(GEOMETRY, screw)
    meshes = [(4, 3, 4), tube.MESH, (16, 10, 16)]
    found = [constants(flank.finite_element_grid(mesh)) for mesh in meshes]
    np.testing.assert_allclose(found[0], found[2], rtol=5e-3)
    np.testing.assert_allclose(found[1], found[2], rtol=4e-4)
    assert np.all(found[0] >= found[1])
    assert np.all(found[1] >= found[2])
    section = parts.grooved_section(GEOMETRY, screw)
    np.testing.assert_allclose(of_section(section), found[1], rtol=1e-12)


def test_nothing_is_left_out_of_a_shallow_groove():
    """A land just above the groove's root: the plain shaft again, to first order in what is cut away."""
    gaps = []
    for depth in (0.4e-3, 0.1e-3):
        land = ROOT + depth
        gaps.append(1.0 - of_section(of_screw(land=land)) / of_section(tube_section(2 * land, 0.0, STEEL)))
    assert np.all(gaps[0] < 0.02)
    assert np.all(gaps[1] > 0.0)
    assert np.all(gaps[1] < 0.3 * gaps[0])


def test_the_helix_changes_half_a_per_cent():
    """The ring groove in place of the helix, against a section on its helix by other elements."""
    stiffness, EI = stiffness_of_grooved_shaft(MAP, LAND, 0.0, STEEL)
    yielding = np.linalg.inv(stiffness)
    section = of_screw()
    wanted = np.array([1.0 / yielding[0, 0], EI, 1.0 / yielding[1, 1]])
    np.testing.assert_allclose([section.EA, section.EI, section.GJ], wanted, rtol=0.01)
    assert wanted[2] > section.GJ


@pytest.mark.parametrize("name", ["lin-case1", "unseen-40x10", "liu-drawn"])
def test_the_layer_is_as_stiff_as_the_grooved_section(name):
    """EA and GJ are what its two powers are chosen for, beside a body whose layer may widen; EI follows."""
    geometry = parts.reduce_to_compliance_geometry(catalogue.scene(name))
    layered, grooved = parts.smooth_body(geometry, False, parts.REFINED).section, parts.grooved_section(geometry, False)
    assert of_section(layered) == pytest.approx(of_section(grooved), rel=8e-3)
    plain = parts.smooth_body(geometry, False, replace(parts.REFINED, bore="ring")).section
    assert plain.EA > 1.02 * grooved.EA  # rings alone are too stiff along the axis


def test_a_bearing_s_outer_ring_is_a_tube_of_its_outer_diameter():
    """EA = E pi (R^2 - r^2) and 4 EI / EA = R^2 + r^2 give both radii; the inner one is that of the bore's volume, two arcs
    that meet at the apex, between cylindrical lands."""
    scene = catalogue.scene("bearing-9")
    section, E = parts.grooved_section(parts.reduce_to_compliance_geometry(scene), False), scene.nut.material.youngs_modulus
    difference, total = section.EA / (np.pi * E), 4.0 * section.EI / section.EA
    outer, inner = np.sqrt(0.5 * (total + difference)), np.sqrt(0.5 * (total - difference))
    assert outer == pytest.approx(scene.nut.outer_diameter / 2.0, rel=1e-9)
    radius, angle = scene.nut.groove_radius, scene.track.contact_angle
    beside, above = (f(angle) * (radius - scene.balls.radius) for f in (np.sin, np.cos))
    across = np.linspace(0.0, scene.nut.length / 2.0, 20_001) + beside
    arc = scene.track.pitch_radius - above + np.sqrt(np.maximum(radius**2 - across**2, 0.0))
    bore = np.maximum(arc, parts.half_groove_of_body(parts.reduce_to_compliance_geometry(scene), False).land_radius)
    assert inner == pytest.approx(np.sqrt((bore**2).mean()), rel=1e-3)
