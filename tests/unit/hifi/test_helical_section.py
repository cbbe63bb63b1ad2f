"""Grooved shafts: section on the helix, plain shafts exactly, hands, starts and convergence; cut ends on a beam that sways
with its groove, where all is known, and on meshed shafts; motion of a section as the mean of its material."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.bodies.coarse import all_freedoms_with_rigid_end
from rollbench.hifi.condensation import section_motion_matrix
from rollbench.hifi.elements.forms import elastic_stiffness
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions, rigid_motion_transfer_along_z
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.shaft import section
from rollbench.hifi.shaft.beam import ShaftSection, end_flexibility_of_cantilever, round_section, tube_section
from rollbench.hifi.shaft.section import meshed_shaft_flexibility, stiffness_of_grooved_shaft
from rollbench.meshes.fem import node_coordinates
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.sockets import RefinementBoxSize
from rollbench.meshes.solid import dimensions_of_3d_parts

pytestmark = pytest.mark.xdist_group("cut shafts")

SCENE = catalogue.scene("lin-case1")
STEEL, LAND = SCENE.screw.material, SCENE.screw.outer_diameter / 2.0
MAP = GrooveMap.from_scene(SCENE)
RIGHT = replace(MAP, phase=0.7)
HANDS = {"right": RIGHT, "left": replace(RIGHT, rg=-RIGHT.rg), "two starts": replace(RIGHT, starts=2)}
UNIT = np.array([RIGHT.R] * 3 + [1.0] * 3)
SIZE = np.outer(UNIT, UNIT)
LEAD = 2.0 * np.pi * abs(RIGHT.rg)
#: Flexibility of a metre along the groove: what sways (x towards the groove), and its mean over a lead.
SECTION = ShaftSection(1.5e8, 9e3, 7e3, 5e7)
MEAN = np.diag([1 / SECTION.kGA] * 2 + [1 / SECTION.EA] + [1 / SECTION.EI] * 2 + [1 / SECTION.GJ])


def swaying():
    """Flexibility of a metre in the frame of the groove: as a helical shaft has it, odd entries under half a turn zero."""
    c = np.zeros((6, 6))
    for i, j, value in ((0, 0, 0.1), (1, 1, -0.1), (3, 3, 0.15), (4, 4, -0.15), (2, 4, 0.2), (5, 4, -0.1), (1, 2, 0.1)):
        c[i, j] = c[j, i] = value * np.sqrt(MEAN[i, i] * MEAN[j, j])
    c[0, 3] = c[3, 0] = 2e-6
    c[1, 4] = c[4, 1] = -2e-6
    assert np.allclose(section.HALF_TURN @ c @ section.HALF_TURN, c)
    return MEAN + c


def cut_end():
    """What a rigid section does besides, any symmetric matrix."""
    rng = np.random.default_rng(1)
    A = rng.normal(size=(6, 6))
    return -SIZE * (A + A.T) * 0.02 * RIGHT.R / SECTION.EI


def between(m, near, far, a, b):
    """Motion at a by a wrench at b of the swaying shaft held at ``near``, its upper end at ``far`` [m]."""
    reach = min(a, b) - near
    x, w = np.polynomial.legendre.leggauss(60)

    def moved(flexibility, z):
        return rigid_motion_transfer_along_z(a - z) @ flexibility @ rigid_motion_transfer_along_z(b - z).T

    out = moved(section.flexibility_of_lower_cut_end(cut_end(), m, near), near)
    for z, weight in zip(near + reach * (x + 1) / 2, reach * w / 2, strict=True):
        out += weight * moved(section.rotate_flexibility(swaying(), section.groove_azimuth(m, z)), z)
    return out + section.flexibility_of_upper_cut_end(cut_end(), m, far) * (a == far and b == far)


def both_cuts(E, m, length):
    """Flexibility that the cuts at both ends add to a shaft held at its lower end."""
    T, half = rigid_motion_transfer_along_z(length), length / 2
    low = section.flexibility_of_lower_cut_end(E, m, m.z0 - half)
    return T @ low @ T.T + section.flexibility_of_upper_cut_end(E, m, m.z0 + half)


def shaft(m, length):
    low, high = m.z0 - length / 2, m.z0 + length / 2
    return between(m, low, high, high, high)


def known(m):
    """E of the swaying shaft: found from shafts of three lengths."""
    return section.fit_flexibility_of_cut_end(m, [(k * LEAD, shaft(m, k * LEAD)) for k in (2, 4, 2.25)], MEAN)


@pytest.mark.parametrize("hand", HANDS)
def test_shafts_of_any_length_are_a_beam_and_two_cuts(hand):
    m = HANDS[hand]
    E = known(m)
    for length in (1.8 * LEAD, 2.5 * LEAD, 5.1 * LEAD):
        wanted = shaft(m, length) - end_flexibility_of_cantilever(length, MEAN)
        np.testing.assert_allclose(both_cuts(E, m, length) / SIZE, wanted / SIZE, atol=1e-11)
        assert np.abs(wanted[3:, 2]).max() > 1e-10  # an axial force bends


@pytest.fixture(scope="module")
def meshed():
    """Left-hand shaft of a bore of 8 mm: its section and cut, and the meshed shafts from which they come."""
    m, bore = HANDS["left"], 4e-3
    lengths = section.choose_lengths_of_fitted_shafts(m)
    shafts = [meshed_shaft_flexibility(m, 16e-3, bore, STEEL, 8e-3, length) for length in lengths]
    stiffness = stiffness_of_grooved_shaft(m, 16e-3, bore, STEEL)
    return section.compute_equivalent_beam(m, bore, STEEL, stiffness, shafts), shafts


def test_a_hollow_shaft_shears_as_a_tube(meshed):
    """Cowper's limits: solid, and a thin wall. The section's wall ends at its bore."""
    nu = 0.3
    for bore, kappa, close in ((0.0, 6.0 / (7.0 + 6.0 * nu), 1e-12), (19.99e-3, 2.0 / (4.0 + 3.0 * nu), 1e-5)):
        plain = round_section(20e-3, 210e9, nu, bore)
        assert plain.kGA == pytest.approx(0.5 * kappa * plain.EA, rel=close)  # G = E / (2 (1 + nu)), kappa / (1 + nu)
    found = meshed[0]
    hollow, solid = (tube_section(found.equivalent_radii[1], bore, STEEL).kGA for bore in (4e-3, 0.0))
    assert found.section.kGA == hollow < 0.83 * solid


def test_a_meshed_shaft_is_beam_and_cuts(meshed):
    """A shaft of another length and phase than those that the cut comes from: a tenth of what the cuts do is left, by the
    mesh and by the coupling of shear and bending that no beam here has; of what bends it under an axial force, 6 %."""
    found, shafts, m = *meshed, HANDS["left"]
    (least, short), (most, long), _ = shafts
    mesh = (long - short) / (most - least)  # as stiff as this mesh: what it has too much is not the cut's
    uniform = np.diag([1 / found.section.kGA] * 2 + [mesh[2, 2]] + [0.5 * (mesh[3, 3] + mesh[4, 4])] * 2 + [mesh[5, 5]])
    uniform[2, 5] = uniform[5, 2] = mesh[2, 5]
    length, F = meshed_shaft_flexibility(m, 16e-3, 4e-3, STEEL, 8e-3, 2.5 * 20e-3)
    F = F / SIZE
    stake = F - end_flexibility_of_cantilever(length, uniform) / SIZE
    left = stake - both_cuts(found.cut_end_flexibility, m, length) / SIZE
    assert np.linalg.norm(stake) > 0.02 * np.linalg.norm(F)
    assert np.linalg.norm(left) < 2.5e-3 * np.linalg.norm(F)
    assert np.hypot(*stake[3:5, 2]) > 0.045 * F[2, 2]
    assert np.hypot(*left[3:5, 2]) < 0.06 * np.hypot(*stake[3:5, 2])


@pytest.mark.slow
def test_3d_shafts_converge_to_it() -> None:
    """One lead of 3D shaft, as the difference of two and one, stiffer the coarser its cells; its coupling of stretch and
    twist, a few thousandths of either, has the sign of the section's and comes near it more slowly."""
    bore, lead = 4e-3, 2.0 * np.pi * MAP.rg
    A, EI = stiffness_of_grooved_shaft(MAP, LAND, bore, STEEL)
    yielding = np.linalg.inv(A)
    off = []
    for size in (6e-3, 4.2e-3):
        short, long = (meshed_shaft_flexibility(MAP, LAND, bore, STEEL, size, k * lead)[1] for k in (1, 2))
        mesh = (long - short) / lead
        found = np.array([mesh[2, 2], mesh[5, 5], 0.5 * (mesh[3, 3] + mesh[4, 4]), mesh[2, 5]])
        off.append(1.0 - found / [yielding[0, 0], yielding[1, 1], 1.0 / EI, yielding[0, 1]])
        assert np.all((off[-1] > 0.0) & (off[-1] < [0.025, 0.025, 0.025, 0.5]))
    assert np.all(off[1] < 0.8 * off[0])


@pytest.mark.slow
def test_a_load_on_a_section_moves_it_as_beam_theory_has_it_and_rigid_motions_are_found_exactly() -> None:
    """Own flexibility of a section inside: a load on a few nodes of the hole turns these far more than the section."""
    scene, length = catalogue.scene("unseen-16x5"), 48e-3
    m, land, hole = GrooveMap.from_scene(scene), scene.screw.outer_diameter / 2.0, dimensions_of_3d_parts(scene).hole
    spec = GroovedBodySpec(hole, land, m.z0, m.z0 + length, True, (), RefinementBoxSize(0.3, 1e-3, 0.05), 4e-3, 4e-3)
    mesh, z = mesh_grooved_body(m, spec).mesh, m.z0 + 0.4 * length
    rigid = nodal_displacements_of_rigid_motions(node_coordinates(mesh), np.array([0.0, 0.0, z]))
    np.testing.assert_allclose(section_motion_matrix(mesh, z) @ rigid, np.eye(6), atol=1e-9)
    z, e = m.z0 + 0.5 * length, scene.screw.material
    K = elastic_stiffness(mesh, e.youngs_modulus, e.poissons_ratio)
    T = all_freedoms_with_rigid_end(mesh, m.z0 + length)
    flexibility = symmetric_compliance_of_loads((T.T @ K @ T).tocsc(), section_motion_matrix(mesh, z) @ T)
    stretch, EI = stiffness_of_grooved_shaft(m, land, 0.0, e)
    flexible = np.linalg.inv(stretch)
    found = np.diag(flexibility)[[2, 3, 4, 5]] / (z - m.z0)
    assert found == pytest.approx([flexible[0, 0], 1.0 / EI, 1.0 / EI, flexible[1, 1]], rel=0.08)
