"""3D bearings whose grooves are one arc: one flank of the mesh, one contact of a ball with it."""

from dataclasses import replace

import numpy as np
import pytest
from tests.two_balls import SMALL
from tests.unit.statics.test_one_arc import bearing

from rollbench.compare.reference.tasks import flanks_to_mesh
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Support
from rollbench.meshes.sockets import section_angles_of_flank

BALL = {"ball_fine": 1.2e-3, "ball_coarse": 2.4e-3, "ball_modes": 24}
COARSE = replace(SMALL, b_over_h=1.0, semi=(0.9e-3, 0.2e-3), reach=(1.1e-3, 0.2e-3), modes=16, **BALL)


@pytest.mark.slow
@pytest.mark.usefixtures("_one_submodel")
@pytest.mark.parametrize(
    ("contact_angle", "arcs", "moved", "close"),
    [
        pytest.param(0.01, None, (10e-6, 30e-6), 0.03, id="radial"),
        pytest.param(6.0, "+z", (8e-6, 5e-6), 0.05, id="thrust upwards"),
    ],
)
def test_loads_are_those_of_elastic_rings(contact_angle, arcs, moved, close) -> None:
    """Also of a row that carries thrust one way, whose ellipses, about 6 deg wide about a contact angle of 6 deg, meet the
    bottom of the groove: two arcs would end at an apex under them. The mesh is coarse."""
    scene = bearing(contact_angle, 0.0, 0.0)
    fixed = ("ux", moved[0]), ("uy", 0.0), ("uz", moved[1]), ("rx", 0.0), ("ry", 0.0), ("rz", 0.0)
    scene = replace(
        scene,
        loads=(),
        track=replace(scene.track, arcs=arcs or scene.track.arcs),
        balls=replace(scene.balls, azimuths=(-0.4, 0.5)),
        supports=(Support(0.008, fixed),),
    )
    assert flanks_to_mesh(scene) == (0, 3)
    found, low = solve_reference(mesh_and_condense_geometry(scene, (0, 3), COARSE), scene), solve_elastic(scene)
    assert found.status == "converged"
    np.testing.assert_allclose(found.contact_loads[:, [0, 3]], low.load[:, [0, 3]], rtol=close)
    np.testing.assert_allclose(found.contact_angles[:, 0], low.contact_angle[:, 0], atol=np.radians(0.3))
    assert not found.contact_loads[:, [1, 2]].any()


@pytest.mark.parametrize("way", ["+z", "-z"])
def test_the_section_of_one_arc_is_even_about_its_own_middle(way: str) -> None:
    scene = bearing(15.0, 1.0, 0.0)
    scene = replace(scene, track=replace(scene.track, arcs=way))
    m = GrooveMap.from_scene(scene)
    for side in m.flanks_of_single_arc:
        land = scene.screw.outer_diameter / 2.0 if side < 2 else 2.0 * m.R - scene.screw.outer_diameter / 2.0
        low, high = section_angles_of_flank(m, side, land)
        assert low == -high
        z = [float(m.polar_to_section(side, np.array(g), m.radius[side])[1]) for g in (low, high)]
        assert np.mean(z) == pytest.approx(m.centre[side, 1], abs=1e-12)
        assert abs(m.centre[side, 1]) == pytest.approx((m.radius[side] - m.ball) * np.sin(m.beta))
