"""Tangent stiffness at a section of the screw against finite differences of the nonlinear solution, and reciprocity."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics import static, tangent
from rollbench.meshes.parts import FREEDOMS, Support

MOTION = np.array([2e-6, -1e-6, 3e-6, 2e-5, -1e-5, 0.0])
STEP = np.array([1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6])

ALL = tuple((name, 0.0) for name in FREEDOMS)


def clamped(scene, station, motion):
    support = Support(station, tuple(zip(FREEDOMS, motion, strict=True)))
    return replace(scene, supports=(support,), loads=())


def reaction(scene, station, motion, backend):
    """Force and moment (6,) on the screw's section that holds it at a motion."""
    result = static.solve_elastic(clamped(scene, station, motion), backend=backend)
    assert result.converged
    balance = result.equilibrium
    force = balance.reaction_force
    return np.concatenate([force, balance.reaction_moment - np.cross([0.0, 0.0, station], force)])


@pytest.mark.parametrize(("model", "station"), [("refined", 0.13), ("refined", 0.1), ("lin", 0.13), ("lin", 0.1)])
def test_against_finite_differences_of_the_solution_and_reciprocal(model, station):
    scene, backend = small_screw(4, oversize=4e-6), LADDER[model]
    found = tangent.tangent_stiffness(clamped(scene, station, MOTION), station, backend=backend)
    steps = [[reaction(scene, station, MOTION + way * h, backend) for way in (1.0, -1.0)] for h in np.diag(STEP)]
    measured = np.array([(there - back) / (2.0 * h) for (there, back), h in zip(steps, STEP, strict=True)]).T
    size = np.sqrt(np.diag(measured))
    assert np.abs((measured - measured.T) / np.outer(size, size)).max() < 1e-4
    # lever arms turn with the contacts' forces in the nonlinear solution, which small motions leave alone
    assert np.abs((found.matrix - measured) / np.outer(size, size)).max() < 1e-3
    assert np.array_equal(found.matrix, found.matrix.T)


def test_a_rigid_screw_carries_the_motion_of_its_clamp():
    """Moved along the axis, a clamp of a rigid screw sees the same wrench about another point."""
    scene = replace(small_screw(4, oversize=4e-6, fixed=ALL, screw="rigid"), loads=())
    here, there = (tangent.tangent_stiffness(scene, z, backend=LADDER["lin"]).matrix for z in (0.1, 0.16))
    t = np.eye(6)
    t[0, 4], t[1, 3] = 0.1 - 0.16, -(0.1 - 0.16)
    np.testing.assert_allclose(there, t.T @ here @ t, rtol=1e-9, atol=1e-9 * np.abs(here).max())


def test_equal_balls_on_rigid_bodies_have_the_closed_form_along_the_axis():
    scene = replace(small_screw(4, lead=0.0, oversize=4e-6, fixed=ALL, screw="rigid"), loads=())
    result = static.solve_elastic(scene, backend=LADDER["lin"])
    stiff = 1.5 * np.cbrt(result.load) / result.hertz_C
    normal = 1.0 / (1.0 / stiff[:, 0] + 1.0 / stiff[:, 3]) + 1.0 / (1.0 / stiff[:, 1] + 1.0 / stiff[:, 2])
    beta = scene.track.contact_angle
    found = tangent.tangent_stiffness(scene, 0.1, backend=LADDER["lin"])
    # across the line of contacts the forces turn: F over the distance of the grooves' centres, a few thousandths
    assert found.matrix[2, 2] == pytest.approx(float((normal * np.sin(beta) ** 2).sum()), rel=0.02)


def test_a_scene_that_nothing_holds_says_so_and_a_station_off_the_screw_is_refused():
    scene = small_screw(4, force=(0.0, 0.0, -500.0), fixed=(("ux", 0.0), ("uy", 0.0)))
    found = tangent.tangent_stiffness(scene, 0.1, backend=LADDER["lin"])
    assert found.status.startswith("not held")
    assert np.isnan(found.matrix).all()
    with pytest.raises(ValueError, match="200 mm"):
        tangent.tangent_stiffness(small_screw(4), 0.3, backend=LADDER["lin"])
