"""The section of a grooved shaft on its helix: plain shafts exactly, hands, starts, convergence, and 3D shafts."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.shaft.beam import round_section
from rollbench.hifi.shaft.section import meshed_shaft_flexibility, stiffness_of_grooved_shaft
from rollbench.meshes.groove_map import GrooveMap

SCENE = catalogue.scene("lin-case1")
STEEL = SCENE.screw.material
MAP = GrooveMap.from_scene(SCENE)
LAND = SCENE.screw.outer_diameter / 2.0
COARSE = (12, 6, 6)


def radius_at_apex(m: GrooveMap) -> float:
    """Least radius [m] of the screw's groove."""
    gamma = np.linspace(0.0, np.pi / 2.0, 2001)
    r, zeta, _ = m.section_to_unrolled(*m.polar_to_section(1, gamma, np.full(gamma.size, m.radius[1])))
    return float(r[zeta >= 0.0].min())


@pytest.mark.parametrize("bore", [0.0, 6e-3])
def test_a_shaft_with_a_scratch_is_plain(bore: float) -> None:
    """A groove of a thousandth of the radius: what it takes away is that, to first order, of a thin layer at most."""
    outer = 1.001 * radius_at_apex(MAP)
    stiffness, EI = stiffness_of_grooved_shaft(MAP, outer, bore, STEEL, COARSE)
    e, nu = STEEL.youngs_modulus, STEEL.poissons_ratio
    solid, hole = round_section(outer, e, nu), round_section(max(bore, 1e-9), e, nu)
    wanted = np.array([solid.EA - hole.EA, solid.GJ - hole.GJ, solid.EI - hole.EI])
    found = np.array([stiffness[0, 0], stiffness[1, 1], EI])
    assert np.all(found < wanted)
    np.testing.assert_allclose(found, wanted, rtol=8e-4)
    assert abs(stiffness[0, 1]) < 1e-5 * np.sqrt(stiffness[0, 0] * stiffness[1, 1])


def test_the_hand_turns_the_coupling_of_stretch_and_twist_alone() -> None:
    left = GrooveMap.from_scene(replace(SCENE, track=replace(SCENE.track, hand="left")))
    (right_A, right_EI), (left_A, left_EI) = (stiffness_of_grooved_shaft(m, LAND, 0.0, STEEL, COARSE) for m in (MAP, left))
    np.testing.assert_allclose(left_A * [[1, -1], [-1, 1]], right_A, rtol=1e-9)
    assert left_EI == pytest.approx(right_EI, rel=1e-9)
    assert abs(right_A[0, 1]) > 1e-3 * np.sqrt(right_A[0, 0] * right_A[1, 1])


def test_finer_cells_converge() -> None:
    found = [stiffness_of_grooved_shaft(MAP, LAND, 0.0, STEEL, cells) for cells in (COARSE, (18, 9, 9), (24, 12, 12))]
    EI = np.array([x[1] for x in found])
    assert EI[0] > EI[1] > EI[2]
    assert EI[1] - EI[2] < 0.4 * (EI[0] - EI[1])
    assert stiffness_of_grooved_shaft(MAP, LAND, 0.0, STEEL)[1] == pytest.approx(EI[2], rel=4e-4)


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
        bend = 0.5 * (mesh[3, 3] + mesh[4, 4])
        direct = 1.0 - mesh[2, 2] / yielding[0, 0], 1.0 - mesh[5, 5] / yielding[1, 1], 1.0 - bend * EI
        off.append([*direct, 1.0 - mesh[2, 5] / yielding[0, 1]])
    assert np.all(np.array(off) > 0.0)
    assert np.all(np.array(off) < [0.025, 0.025, 0.025, 0.5])
    assert np.all(np.array(off[1]) < 0.8 * np.array(off[0]))


def test_impossible_dimensions_are_refused() -> None:
    four = GrooveMap.from_scene(replace(SCENE, track=replace(SCENE.track, starts=4)))
    for m, bore, why in ((four, 0.0, "overlap"), (MAP, LAND - 1e-3, "bore")):
        with pytest.raises(ValueError, match=why):
            stiffness_of_grooved_shaft(m, LAND, bore, STEEL)
