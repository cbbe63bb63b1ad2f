"""Cut ends of a grooved shaft: on a beam that sways with its groove, where all is known, and on meshed shafts."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.shaft import section as cell
from rollbench.hifi.shaft import section as shaft_section
from rollbench.hifi.shaft.beam import ShaftSection, end_flexibility_of_cantilever, round_section, tube_section
from rollbench.hifi.shaft.mounting import MeshedShaftPart, subtract_cut_end_flexibility, support_shaft_part
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import FREEDOMS, Load, Support

pytestmark = pytest.mark.xdist_group("cut shafts")

SCENE = catalogue.scene("lin-case1")
RIGHT = replace(GrooveMap.from_scene(SCENE), phase=0.7)
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
    assert np.allclose(shaft_section.HALF_TURN @ c @ shaft_section.HALF_TURN, c)
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
    out = np.zeros((6, 6))
    for z, weight in zip(near + reach * (x + 1) / 2, reach * w / 2, strict=True):
        out += (
            weight
            * rigid_motion_transfer_along_z(a - z)
            @ shaft_section.rotate_flexibility(swaying(), shaft_section.groove_azimuth(m, z))
            @ rigid_motion_transfer_along_z(b - z).T
        )
    out += (
        rigid_motion_transfer_along_z(a - near)
        @ shaft_section.flexibility_of_lower_cut_end(cut_end(), m, near)
        @ rigid_motion_transfer_along_z(b - near).T
    )
    return out + shaft_section.flexibility_of_upper_cut_end(cut_end(), m, far) * (a == far and b == far)


def shaft(m, length):
    low, high = m.z0 - length / 2, m.z0 + length / 2
    return between(m, low, high, high, high)


def known(m, leads=(2, 4, 2.25), beam=0.0 * MEAN):
    """E of the swaying shaft: found from so many lengths; beam: what is added to each metre."""
    lengths = [k * LEAD for k in leads]
    return shaft_section.fit_flexibility_of_cut_end(
        m, [(x, shaft(m, x) + end_flexibility_of_cantilever(x, beam)) for x in lengths], MEAN
    )


@pytest.mark.parametrize("hand", HANDS)
def test_shafts_of_any_length_are_a_beam_and_two_cuts(hand):
    m = HANDS[hand]
    E = known(m)
    for length in (1.8 * LEAD, 2.5 * LEAD, 5.1 * LEAD):
        T, half = rigid_motion_transfer_along_z(length), length / 2
        ends = T @ shaft_section.flexibility_of_lower_cut_end(
            E, m, m.z0 - half
        ) @ T.T + shaft_section.flexibility_of_upper_cut_end(E, m, m.z0 + half)
        wanted = shaft(m, length) - end_flexibility_of_cantilever(length, MEAN)
        np.testing.assert_allclose(ends / SIZE, wanted / SIZE, atol=1e-11)
        assert np.abs(wanted[3:, 2]).max() > 1e-10  # an axial force bends


def stretch(m, low, high):
    """The swaying shaft as the 3D stretch of a screw; every contact has the six motions of its section as modes."""
    places = [0.37, 0.4, 0.42, high, 0.4]
    F = np.block([[between(m, low, high, a, b) for b in places] for a in places])
    B = np.concatenate([rigid_motion_transfer_along_z(z - low) for z in places])
    return MeshedShaftPart(F, B, low, (high,), (0.4,), (low, high), 18)


@pytest.mark.parametrize("hand", HANDS)
@pytest.mark.parametrize("ends", [(0.341, 0.442), (0.345, 0.47), (0.32, 0.46)])
def test_a_longer_stretch_answers_like_the_shorter_one_between_beams(hand, ends):
    m = HANDS[hand]
    E = known(m)
    supports = (Support(0.0, tuple((f, 0.0) for f in FREEDOMS)), Support(0.8, (("ux", 3e-4), ("uy", 0.0))))
    scene = replace(SCENE, supports=supports, loads=(Load(0.8, (0.0, 50.0, 5e3), (1.0, 2.0, 3.0)),))

    def answers(low, high):
        found = support_shaft_part(subtract_cut_end_flexibility(stretch(m, low, high), E, m, (0.0, 0.8)), scene, SECTION)
        return found.G / np.tile(SIZE, (3, 3)), found.mode_displacements_by_loads / np.tile(UNIT, 3)

    for one, other, left in zip(answers(0.35, 0.45), answers(*ends), (1e-9, 1e-8), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=left * np.abs(one).max())


@pytest.fixture(scope="module")
def meshed():
    """Left-hand shaft of a bore of 8 mm, meshed: its section and cut, and flexibilities, each length meshed once."""
    m, steel, bore, known = HANDS["left"], SCENE.screw.material, 4e-3, {}

    def once(length):
        if (key := round(length, 9)) not in known:
            known[key] = cell.meshed_shaft_flexibility(m, 16e-3, bore, steel, 8e-3, length)
        return known[key]

    section = shaft_section.stiffness_of_grooved_shaft(m, 16e-3, bore, steel)
    found = cell.compute_equivalent_beam(
        m, bore, steel, section, [once(length) for length in cell.choose_lengths_of_fitted_shafts(m)]
    )
    return found, lambda length: once(length)[1], known


def test_a_homogenised_shaft_lies_between_root_and_lands(meshed):
    found, m = meshed[0], HANDS["left"]
    root = m.R - m.radius[0] * np.cos(np.pi / 4)
    assert all(root < r < 16e-3 for r in found.equivalent_radii)
    assert found.equivalent_radii[0] < found.equivalent_radii[1] < found.equivalent_radii[2]  # axial, bending, torsion
    assert abs(found.axial_torsional_coupling) < 0.02
    # volume: the axial section can be no stiffer than the mean cross-section (Voigt)
    groove = 0.5 * 3.254e-3**2 * (np.pi - 0.9)
    area = np.pi * (16e-3**2 - 4e-3**2) - 2.0 * np.pi * m.R * groove / 20e-3 * 0.8
    assert 1.02 * SCENE.screw.material.youngs_modulus * area > found.section.EA


def test_a_hollow_shaft_shears_as_a_tube(meshed):
    """Cowper's limits: solid, and a thin wall. The section's wall ends at its bore."""
    nu = 0.3
    for bore, kappa, close in ((0.0, 6.0 / (7.0 + 6.0 * nu), 1e-12), (19.99e-3, 2.0 / (4.0 + 3.0 * nu), 1e-5)):
        plain = round_section(20e-3, 210e9, nu, bore)
        assert plain.kGA == pytest.approx(0.5 * kappa * plain.EA, rel=close)  # G = E / (2 (1 + nu)), kappa / (1 + nu)
    found, steel = meshed[0], SCENE.screw.material
    assert (
        found.section.kGA
        == tube_section(found.equivalent_radii[1], 4e-3, steel).kGA
        < 0.83 * tube_section(found.equivalent_radii[1], 0.0, steel).kGA
    )


def test_a_meshed_shaft_is_beam_and_cuts(meshed):
    """A shaft of another length and phase than those that the cut comes from: a tenth of what the cuts do is left, by the
    mesh and by the coupling of shear and bending that no beam here has; of what bends it under an axial force, 6 %."""
    (found, flexibility, known), m = meshed, HANDS["left"]
    leads = int(np.ceil(2.4 * m.R / 20e-3))
    short, long = (flexibility(k * leads * 20e-3) for k in (1, 2))
    assert len(known) == 3
    mesh = (long - short) / (leads * 20e-3)  # as stiff as this mesh: what it has too much is not the cut's
    uniform = np.diag([1 / found.section.kGA] * 2 + [mesh[2, 2]] + [0.5 * (mesh[3, 3] + mesh[4, 4])] * 2 + [mesh[5, 5]])
    uniform[2, 5] = uniform[5, 2] = mesh[2, 5]
    length = 2.5 * 20e-3
    T = rigid_motion_transfer_along_z(length)
    F = flexibility(length) / SIZE
    stake = F - end_flexibility_of_cantilever(length, uniform) / SIZE
    left = (
        stake
        - (
            T @ shaft_section.flexibility_of_lower_cut_end(found.cut_end_flexibility, m, m.z0 - length / 2) @ T.T
            + shaft_section.flexibility_of_upper_cut_end(found.cut_end_flexibility, m, m.z0 + length / 2)
        )
        / SIZE
    )
    assert np.linalg.norm(stake) > 0.02 * np.linalg.norm(F)
    assert np.linalg.norm(left) < 2.5e-3 * np.linalg.norm(F)
    assert np.hypot(*stake[3:5, 2]) > 0.045 * F[2, 2]
    assert np.hypot(*left[3:5, 2]) < 0.06 * np.hypot(*stake[3:5, 2])
