"""A nut's groove that ends beyond its loaded balls."""

from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import one, space
from tests.helpers import small_screw, sockets_of

from rollbench.meshes.fem import nodes_on_boundaries
from rollbench.meshes.groove import GrooveCrossSection, GroovedBodySpec, GrooveRunOut
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.parts import SIDES
from rollbench.meshes.sockets import RefinementBoxSize, helix_constants_of_starts, points_in_refinement_box
from rollbench.meshes.solid import RUN_OUT, WHOLE, dimensions_of_3d_parts

SIZE = RefinementBoxSize(0.30, 1.2e-3, 0.075)


def map_and_spec(case, sides):
    """Map and spec of a nut of 50 mm whose groove ends."""
    z = case.nut.position
    ends = z - 25e-3, z + 25e-3
    return GrooveMap.from_scene(case), GroovedBodySpec(
        17e-3, 24e-3, *ends, False, sockets_of(case, sides), SIZE, 2e-3, 7e-3, groove_ends_inside=True
    )


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("starts", [1, 2])
def test_the_groove_is_whole_at_every_ball_and_ends_beyond_the_outermost(hand, starts):
    case = small_screw(6, hand=hand, phase=0.3)
    case = replace(case, track=replace(case.track, starts=starts))
    m, spec = map_and_spec(case, (2, 3))
    ends = GrooveRunOut.from_ball_positions(m, spec.contact_positions, SIZE)
    ball = 2.0 * m.ball / np.hypot(m.R, m.rg)
    reached = 0
    for line in helix_constants_of_starts(m):
        turns = [(z - line) / m.rg for phi, z, _ in spec.contact_positions]  # total azimuth of a ball on this line
        on = np.array(
            [t for t, (phi, *_) in zip(turns, spec.contact_positions, strict=True) if abs(np.sin((t - phi) / 2)) < 1e-9]
        )
        reached += on.size
        np.testing.assert_array_equal(ends.relative_depth(line, on), 1.0)
        for sign, last in ((-1.0, on.min()), (1.0, on.max())):
            beyond = last + sign * ball * np.array([0.0, WHOLE, WHOLE + 0.5 * RUN_OUT, WHOLE + RUN_OUT, 9.0])
            np.testing.assert_allclose(ends.relative_depth(line, beyond), [1.0, 1.0, 0.5, 0.0, 0.0], atol=1e-9)
            phi = last + sign * ball * np.array([-0.5, 0.9 * WHOLE, 1.1 * WHOLE])
            points = np.stack([m.R * np.cos(phi), m.R * np.sin(phi), line + m.rg * phi + 1e-3], axis=1)
            np.testing.assert_array_equal(ends.has_full_depth(points), [True, True, False])
    assert reached == len(spec.contact_positions)


@pytest.mark.parametrize("hand", ["right", "left"])
def test_a_nut_whose_groove_ends_is_sound(hand):
    """Sockets where they are without ends, flanks exact where the groove is whole and on the land's cylinder where it is
    filled; the volume is that of the tube without the channel of varying depth."""
    m, spec = map_and_spec(small_screw(5, hand=hand, phase=0.3), (2,))
    body, through = mesh_grooved_body(m, spec), mesh_grooved_body(m, replace(spec, groove_ends_inside=False))
    assert body.quality.smallest_jacobian > 0.01
    assert body.flank_deviation < 1e-12
    for nodes, socket in zip(body.nodes_on_box_faces, spec.contact_positions, strict=True):
        found = points_in_refinement_box(m, SIZE, socket, body.box_faces[socket[2]].xi)
        assert np.abs(body.points[nodes] - found).max() < 1e-12 * m.R
    groove = GrooveCrossSection.from_body(m, spec)
    (line,) = helix_constants_of_starts(m)
    filled = 0.0
    phi = np.linspace(-30.0, 30.0, 6001) + (m.z0 - line) / m.rg
    inside = np.abs(line + m.rg * phi - m.z0) < 25e-3
    for side in groove.sides:
        points = body.points[nodes_on_boundaries(body.mesh, f"flank {SIDES[side]}")]
        r = np.hypot(*points[:, :2].T)
        assert (np.abs(r - groove.land_radius) < 1e-12).mean() > 0.1
        assert r.max() - groove.land_radius > 1e-3
        gamma = np.linspace(groove.apex_angle, groove.edge_angle, 201)
        r, zeta = groove.profile_points(side, gamma)

        def channel(depth, r=r, zeta=zeta):
            square = (groove.land_radius + depth * (r - groove.land_radius)) ** 2 - groove.land_radius**2
            return abs(np.trapezoid(0.5 * square, zeta))

        depth = groove.run_out.relative_depth(line, phi[inside])
        filled += np.trapezoid([channel(1.0) - channel(d) for d in depth], phi[inside])
    assert filled > 2e-8
    assert one(space(body.mesh)) - one(space(through.mesh)) == pytest.approx(filled, rel=0.02)


def test_the_groove_of_a_ring_does_not_end():
    ring = small_screw(5, lead=0.0)
    with pytest.raises(ValueError, match="nut_groove"):
        dimensions_of_3d_parts(replace(ring, solid=replace(ring.solid, nut_groove="loaded")))
    with pytest.raises(ValueError, match="ring"):
        GrooveRunOut.from_ball_positions(GrooveMap.from_scene(ring), (), SIZE)
