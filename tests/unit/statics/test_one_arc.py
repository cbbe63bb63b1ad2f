"""A bearing near a contact angle of zero has one arc a groove, and one contact of a ball with it."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL
from tests.shipped_texts import changed, own_text

from rollbench.compare.scenes import scene_file
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_elastic, solve_static
from rollbench.lowfi.statics.tangent import tangent_stiffness
from rollbench.meshes.one_arc import LEAST, has_single_arc_grooves, with_single_arc_grooves
from rollbench.meshes.parts import Errors, Load, Scene, SideErrors, Support

BEARING = own_text("deep-groove")
SOLVERS = {"lin": solve_static, "refined": solve_elastic}


def bearing(angle: float, *force: float) -> Scene:
    scene = scene_file.parse_scene(BEARING.replace("0.01 deg", f"{angle!r} deg"), "deep-groove.toml")
    assert isinstance(scene, Scene)
    return replace(scene, loads=(Load(0.008, (force[0], 0.0, force[1]), (0.0, 0.0, 0.0)),))


@pytest.mark.parametrize("model", SOLVERS)
def test_each_ball_has_one_contact_a_groove_and_stribecks_share(model: str) -> None:
    found = SOLVERS[model](bearing(0.01, 3000.0, 0.0))
    assert found.converged
    assert not any("counted twice" in x or "beyond the groove" in x for x in found.warnings)
    assert (found.load > 0.0).any(axis=0).tolist() == [True, False, False, True]
    azimuth = np.radians([-160.0 + 40.0 * k for k in range(9)])
    assert (found.load[:, 0] * np.cos(azimuth)).sum() == pytest.approx(3000.0, rel=1e-9)
    assert found.load.max() == pytest.approx(4.37 * 3000.0 / 9.0, rel=0.02)  # zero clearance


@pytest.mark.parametrize("model", SOLVERS)
def test_thrust_either_way_turns_the_contact_angle_alike(model: str) -> None:
    there, back = (SOLVERS[model](bearing(0.01, 0.0, sign * 2000.0)) for sign in (1.0, -1.0))
    assert there.status == back.status == "converged"
    np.testing.assert_allclose(back.load, there.load, rtol=1e-5)
    np.testing.assert_allclose(back.contact_angle[:, 0], -there.contact_angle[:, 0], rtol=1e-5)
    assert (np.degrees(there.contact_angle[:, 0]) > 8.0).all()


def test_thrust_between_rigid_rings_in_closed_form() -> None:
    """Groove centres A apart radially at rest and u along the axis: approach sqrt(A^2 + u^2) - A, angle atan(u / A)."""
    scene = bearing(0.01, 0.0, 2000.0)
    found = solve_static(scene)
    centres = 2.0 * 0.25e-3
    angle = found.contact_angle[0, 0]
    moved = centres * np.tan(angle)
    C = hertz_without_errors(scene).C
    force = ((np.hypot(centres, moved) - centres) / (C[0] + C[3])) ** 1.5
    np.testing.assert_allclose(found.load[:, 0], force, rtol=1e-6)
    assert 9.0 * force * np.sin(angle) == pytest.approx(2000.0, rel=1e-6)


def test_screws_and_clear_angles_keep_two_arcs() -> None:
    clear = bearing(15.0, 3000.0, 0.0)
    assert not has_single_arc_grooves(clear)
    assert with_single_arc_grooves(clear) is clear
    near = bearing(2.0, 3000.0, 0.0)
    assert near.track.contact_angle == LEAST
    screw = replace(near, track=replace(near.track, lead=0.01))
    assert not has_single_arc_grooves(screw)


def test_a_set_on_a_shaft_takes_one_arc_unless_its_thrust_is_written() -> None:
    near = ('clearance = { radial = "13 um" }', 'contact_angle = "0.01 deg"')
    for said, thrust, angle in (("", "deep groove", LEAST), ('thrust = "+z"\n', "+z", np.radians(0.01))):
        text = changed("bearings-on-a-shaft", near, ('thrust = "deep groove"\n', said))
        found = scene_file.parse_scene(text, "axis.toml").sets[2]
        assert (found.thrust, found.parts.track.contact_angle) == (thrust, angle)


@pytest.mark.parametrize("profile", [(), (0.0, -2e-6)])
def test_its_tangent_stiffness_is_that_of_finite_differences(profile: tuple[float, ...]) -> None:
    """With one pair of flanks, of exact arcs or not: elastic bodies took all four."""
    scene, step = replace(bearing(0.01, 500.0, 1000.0), errors=Errors(SL=SideErrors(profile=profile))), 1e-3
    held = replace(scene, supports=(Support(0.008, ALL_BUT_AXIAL),))
    base, raised = (replace(held, loads=(Load(0.008, (0.0, 0.0, f)),)) for f in (1000.0, 1000.0 * (1.0 + step)))
    moved = np.diff([solve_static(s).centreline[0, 2] for s in (base, raised)])[0]
    found = tangent_stiffness(base, 0.008, backend=LADDER["lin"])
    assert found.status == "converged"
    assert found.matrix[2, 2] == pytest.approx(1000.0 * step / moved, rel=2e-3)
