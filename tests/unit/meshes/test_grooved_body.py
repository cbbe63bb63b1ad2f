"""Coarse meshes of screws, nuts and rings: volumes, exact closed surfaces, congruent sockets, any scene; a nut's groove
that ends beyond its loaded balls."""

from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import area_of, outer_faces, volume_of
from tests.helpers import STEEL, body_specs, small_screw, sockets_of
from tests.slow import all_slow_but

from rollbench.compare.scenes.catalogue import scene
from rollbench.meshes import sockets
from rollbench.meshes.fem import nodes_on_boundaries, scaled_jacobians
from rollbench.meshes.groove import GrooveCrossSection, GroovedBodySpec, GrooveRunOut
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Balls, Nut, Screw, Track
from rollbench.meshes.sockets import RefinementBoxSize, points_in_refinement_box
from rollbench.meshes.solid import RUN_OUT, WHOLE, dimensions_of_3d_parts

pytestmark = pytest.mark.xdist_group("grooved bodies")

SIZE = RefinementBoxSize(0.30, 1.2e-3, 0.075)


def spec_of(case, sides, outer, size=SIZE, fine=2.0e-3, coarse=7e-3, half=20e-3):
    z, radii = case.nut.position, (8e-3, 15.5e-3) if outer else (17e-3, 24e-3)
    return GroovedBodySpec(*radii, z - half, z + half, outer, sockets_of(case, sides), size, fine, coarse)


def outside(spec):
    """Boundary of the cylinder r = r_out."""
    return "land" if spec.groove_outside else "outside"


def on_surfaces(m, spec, points):
    """Distance [m] of points to the nearest of: cylinders, ends, groove flanks."""
    r, phi, z = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0]), points[:, 2]
    found = [np.abs(r - spec.inner_radius), np.abs(r - spec.outer_radius), np.abs(z - spec.z_low), np.abs(z - spec.z_high)]
    zeta = z - m.z0 + m.rg * (m.phase - phi)
    if m.rg:
        pitch = 2.0 * np.pi * abs(m.rg) / m.starts
        zeta = zeta - pitch * np.round(zeta / pitch)
    sides = (0, 1) if spec.groove_outside else (2, 3)
    found += [np.abs(m.section_to_polar(side, *m.unrolled_to_section(r, zeta))[1] - m.radius[side]) for side in sides]
    return np.min(found, axis=0)


def check_body(m, spec, mesh):
    """What every good mesh of a grooved body is: sound, closed, exact and congruent."""
    assert scaled_jacobians(mesh.mesh).min() > 0.005
    assert mesh.quality.smallest_jacobian > 0.01
    assert (mesh.quality.cell_count, mesh.quality.node_count) == (len(mesh.cells), len(mesh.points))
    assert mesh.flank_deviation < 1e-12
    faces, count = outer_faces(mesh.cells)
    assert count.max() == 2
    assert set(np.unique(mesh.cells)) == set(range(len(mesh.points)))
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [0, 2]]]), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    # all of the surface's nodes lie exactly on it, but for the sockets' inner faces
    assert len(mesh.nodes_on_box_faces) == len(spec.contact_positions)
    assert len(np.unique(mesh.nodes_on_box_faces)) == mesh.nodes_on_box_faces.size
    rest = np.setdiff1d(np.unique(faces), mesh.nodes_on_box_faces)
    assert on_surfaces(m, spec, mesh.points[rest]).max() < 1e-11
    rows = np.sort(faces[:, :3], axis=1)
    inner = {tuple(row) for row in rows[np.isin(rows, mesh.nodes_on_box_faces).all(axis=1)].tolist()}
    for nodes, socket in zip(mesh.nodes_on_box_faces, spec.contact_positions, strict=True):
        standard = mesh.box_faces[socket[2]]
        expected = points_in_refinement_box(m, spec.refinement_box_size, socket, standard.xi)
        assert np.abs(mesh.points[nodes] - expected).max() < 1e-12 * m.R
        assert {tuple(sorted(nodes[t].tolist())) for t in standard.triangles[:, :3]} <= inner
    for nodes, place in (
        (nodes_on_boundaries(mesh.mesh, "low end"), mesh.points[:, 2] - spec.z_low),
        (nodes_on_boundaries(mesh.mesh, "high end"), mesh.points[:, 2] - spec.z_high),
        (nodes_on_boundaries(mesh.mesh, outside(spec)), np.hypot(*mesh.points[:, :2].T) - spec.outer_radius),
    ):
        assert set(nodes) == set(np.unique(faces)) & set(np.flatnonzero(np.abs(place) < 1e-12))


@pytest.fixture(scope="module", params=["screw", "nut"])
def body(request):
    """Map, spec and mesh; of the nut both flanks are loaded: four-sided contact, left hand."""
    outer = request.param == "screw"
    case, sides = (small_screw(6), (0,)) if outer else (small_screw(5, hand="left", phase=0.3), (2, 3))
    m, spec = GrooveMap.from_scene(case), spec_of(case, sides, outer)
    return m, spec, mesh_grooved_body(m, spec)


@pytest.mark.parametrize("lead", [0.0, 5e-3, 20e-3])
@pytest.mark.parametrize("hand", ["right", "left"])
def test_unrolled_points_are_the_section_frames_points_and_roll_brings_them_back(lead, hand):
    case = small_screw(4, lead=lead, hand=hand)
    m, layout = GrooveMap.from_scene(case), ball_layout(case)
    x3, z3 = np.meshgrid(np.linspace(-4e-3, 4e-3, 17), np.linspace(-4e-3, 4e-3, 17))
    r, zeta, psi = m.section_to_unrolled(x3, z3)
    np.testing.assert_allclose(m.unrolled_to_section(r, zeta), (x3, z3), atol=1e-16)
    x3, z3 = np.array([-2e-3, 1e-3, 3e-3]), np.array([2.5e-3, -1e-3, 0.4e-3])
    r, zeta, psi = m.section_to_unrolled(x3, z3)
    for k in range(4):
        expected = layout.centre[k] + x3[:, None] * layout.radial[k] + z3[:, None] * layout.binormal[k]
        up = np.array([0.0, 0.0, layout.z[k] - m.rg * layout.azimuth[k]])
        found = np.add(m.unrolled_to_cartesian(r, zeta, layout.azimuth[k] + psi), up)
        np.testing.assert_allclose(found, expected, atol=1e-15)


def channel_section(m, r_low, r_high, sides):
    """Integral of r dr dzeta over the part of the gothic arch between two radii: the overlap of both flanks' discs."""
    middle = (np.arange(800) + 0.5) / 800.0
    r, zeta = r_low + (r_high - r_low) * middle, 8e-3 * middle - 4e-3
    rr, zz = np.meshgrid(r, zeta, indexing="ij")
    x3, z3 = m.unrolled_to_section(rr, zz)
    inside = np.all([np.hypot(x3 - m.centre[s, 0], z3 - m.centre[s, 1]) < m.radius[s] for s in sides], axis=0)
    return float((rr * inside).sum()) * (r[1] - r[0]) * (zeta[1] - zeta[0])


def volumes_without_sockets(m, spec):
    """Volume of the groove's channel, and of the body without it, between ends that are a whole number of pitches apart:
    over a whole pitch every azimuth meets the channel once, V = pi (r_out^2 - r_in^2) L - 2 pi int r dr dzeta."""
    length, sides = spec.z_high - spec.z_low, (0, 1) if spec.groove_outside else (2, 3)
    pitches = round(length / (2.0 * np.pi * m.rg))
    channel = 2.0 * np.pi * abs(pitches) * channel_section(m, spec.inner_radius, spec.outer_radius, sides)
    return channel, np.pi * (spec.outer_radius**2 - spec.inner_radius**2) * length - channel


@pytest.mark.parametrize("outer", [True, False])
def test_volume_without_sockets(outer):
    case = small_screw(2, phase=0.3)
    m = GrooveMap.from_scene(case)
    spec = replace(spec_of(case, (), outer, half=10e-3), cell_size_far_away=2.2e-3)
    channel, expected = volumes_without_sockets(m, spec)
    assert abs(volume_of(mesh_grooved_body(m, spec)) - expected) < 0.004 * channel


def test_bodies_are_sound_and_their_surfaces_flat_round_and_complete(body):
    """Second-order faces of the smooth cylinder: 2 pi r L, exact to the chords' fourth power."""
    check_body(*body)
    _, spec, mesh = body
    faces, _ = outer_faces(mesh.cells)
    smooth, r = ("bore", spec.inner_radius) if spec.groove_outside else ("outside", spec.outer_radius)

    def area(name):
        return area_of(mesh.points, faces[np.isin(faces, nodes_on_boundaries(mesh.mesh, name)).all(axis=1)])

    assert area(smooth) == pytest.approx(2.0 * np.pi * r * (spec.z_high - spec.z_low), rel=0.03)
    whole = np.pi * (spec.outer_radius**2 - spec.inner_radius**2)
    for end in ("low end", "high end"):
        assert 0.9 * whole < area(end) < 1.001 * whole


UNFIT = [
    (20e-3, {"inner_radius": 13.9e-3, "contact_positions": ()}, "deeper than the wall.*change the bore"),
    (20e-3, {"outer_radius": 13.5e-3, "contact_positions": ()}, "ends before its contact.*move the land"),
    (0.0, {"z_low": 0.0995, "contact_positions": ()}, "only 20.5 mm: widen the ring"),
    (5e-3, {"contact_positions": ()}, "next turn is 5 mm away: no land.*; raise the lead"),
]


@pytest.mark.parametrize(("lead", "change", "match"), UNFIT)
def test_grooves_and_turns_that_do_not_fit_are_refused(lead, change, match):
    case = small_screw(6, lead=lead)
    with pytest.raises(ValueError, match=match):
        mesh_grooved_body(GrooveMap.from_scene(case), replace(spec_of(case, (0,), True), **change))


def even(count, turns):
    return 2.0 * np.pi * turns * ((np.arange(count) + 0.5) / count - 0.5)


def screw_of(azimuths, *, lead=10e-3, hand="right", starts=1, bore=0.0, length=45e-3):
    """Pitch radius 20 mm, balls of 3 mm radius."""
    case = small_screw(2)
    return replace(
        case,
        track=Track(20e-3, lead, np.pi / 4, hand=hand, starts=starts),
        screw=Screw(0.6, 38.6e-3, 3.18e-3, STEEL, bore),
        nut=Nut(0.3, length, 64e-3, 3.18e-3, STEEL),
        balls=Balls(3e-3, STEEL, tuple(float(a) for a in azimuths)),
    )


TWO, FOUR = (0, 3), (0, 1, 2, 3)
#: Label: scene, sides, part.
KINDS = {
    "Table 4.1, nut, four sides": (lambda: scene("lin-nominal-4p1"), FOUR, "nut"),
    "gaps, hollow screw": (lambda: screw_of([-6.0, -5.6, -2.2, 0.3, 0.7, 5.0], bore=10e-3), TWO, "screw"),
    "lead angle of 40 deg": (lambda: screw_of(even(5, 0.4), lead=105e-3, starts=2, length=70e-3), (1, 2), "screw"),
    "screw without a hole": (lambda: small_screw(2), (0,), "screw"),
}


@pytest.mark.parametrize("kind", all_slow_but(["screw without a hole"], KINDS))
def test_any_scene(kind):
    make, sides, name = KINDS[kind]
    case = make()
    hole = 0.0 if "without a hole" in kind else None
    m, spec = GrooveMap.from_scene(case), body_specs(case, sides, fine=4e-3, beyond=6e-3, hole=hole)[name]
    assert len(spec.contact_positions) == case.ball_count * sum((s < 2) == spec.groove_outside for s in sides)
    mesh = mesh_grooved_body(m, spec)
    check_body(m, spec, mesh)
    assert hole is None or np.hypot(*mesh.points[:, :2].T).min() < 2e-3


# --- a groove that ends ---------------------------------------------------------------------------------------------


def map_and_spec(case, sides):
    """Map and spec of a nut of 50 mm whose groove ends."""
    size = 17e-3, 24e-3, case.nut.position - 25e-3, case.nut.position + 25e-3
    spec = GroovedBodySpec(*size, False, sockets_of(case, sides), SIZE, 2e-3, 7e-3, groove_ends_inside=True)
    return GrooveMap.from_scene(case), spec


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("starts", [1, 2])
def test_the_groove_is_whole_at_every_ball_and_ends_beyond_the_outermost(hand, starts):
    case = small_screw(6, hand=hand, phase=0.3)
    case = replace(case, track=replace(case.track, starts=starts))
    m, spec = map_and_spec(case, (2, 3))
    ends = GrooveRunOut.from_ball_positions(m, spec.contact_positions, SIZE)
    ball = 2.0 * m.ball / np.hypot(m.R, m.rg)
    reached = 0
    for line in sockets.helix_constants_of_starts(m):
        phi, z, _ = np.array(spec.contact_positions).T
        turns = (z - line) / m.rg  # total azimuth of a ball on this line
        on = turns[np.abs(np.sin((turns - phi) / 2)) < 1e-9]
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
    (line,) = sockets.helix_constants_of_starts(m)
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
    assert volume_of(body) - volume_of(through) == pytest.approx(filled, rel=0.02)


def test_the_groove_of_a_ring_does_not_end():
    ring = small_screw(5, lead=0.0)
    with pytest.raises(ValueError, match="nut_groove"):
        dimensions_of_3d_parts(replace(ring, solid=replace(ring.solid, nut_groove="loaded")))
