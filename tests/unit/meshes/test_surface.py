"""Groove surfaces against an independent S(phi, gamma): derivatives, normals and principal curvatures."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import FLANK_ERRORS, small_screw

from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Errors
from rollbench.meshes.surface import groove_radius_with_slopes, principal_curvatures, surface_derivatives

#: Signs (s_x, s_z) of the contact direction, written out once more.
DIRECTION = {"SL": (-1, -1), "SR": (-1, 1), "NL": (1, -1), "NR": (1, 1)}
SCREWS = {
    "nominal": {},
    "left hand": {"hand": "left", "phase": 0.7},
    "bearing": {"lead": 0.0},
    "steep": {"lead": 40e-3, "beta": 0.9},
}


def surface(scene, name, phi, gamma):
    """S(phi, gamma) of Lin 2.1, 2.3, 2.6, 2.27, 4.1, 4.3 at one point, for complex arguments too."""
    track, side = scene.track, scene.errors.side(name)
    body = scene.screw if name[0] == "S" else scene.nut
    sx, sz = DIRECTION[name]
    slack, beta = body.groove_radius - scene.balls.radius, track.contact_angle
    angle = phi - (scene.nut.azimuth if name[0] == "N" else 0.0)

    def series(terms):
        return sum(t.sin * np.sin(t.harmonic * angle) + t.cos * np.cos(t.harmonic * angle) for t in terms)

    rg = (1 if track.hand == "right" else -1) * track.lead / (2 * np.pi)
    alpha = np.arctan(rg / track.pitch_radius)
    rho = body.groove_radius - sum(c * gamma**k for k, c in enumerate(side.profile))
    pitch = series(side.pitch) * (np.cos(alpha) if side.pitch_along == "axis" else 1.0)
    x3 = sx * rho * np.cos(gamma) - slack * sx * np.cos(beta) + series(side.roundness)
    z3 = sz * rho * np.sin(gamma) - slack * sz * np.sin(beta) + pitch
    x, y = track.pitch_radius + x3, -z3 * np.sin(alpha)
    c, s = np.cos(phi), np.sin(phi)
    z = scene.nut.position + rg * (phi - track.phase) + z3 * np.cos(alpha)
    return np.array([x * c - y * s, x * s + y * c, z])


def derivatives(scene, name, phi, gamma, h=1e-5):
    """First derivatives by complex step; second ones by central differences of those (error about 1e-10)."""
    tiny = 1e-30

    def by_phi(p, g):
        return surface(scene, name, p + 1j * tiny, g).imag / tiny

    def by_gamma(p, g):
        return surface(scene, name, p, g + 1j * tiny).imag / tiny

    return {
        "Sp": by_phi(phi, gamma),
        "Sg": by_gamma(phi, gamma),
        "Spp": (by_phi(phi + h, gamma) - by_phi(phi - h, gamma)) / (2 * h),
        "Spg": (by_phi(phi, gamma + h) - by_phi(phi, gamma - h)) / (2 * h),
        "Sgg": (by_gamma(phi, gamma + h) - by_gamma(phi, gamma - h)) / (2 * h),
    }


def cylindrical(vector, phi):
    c, s = np.cos(phi), np.sin(phi)
    return np.array([c * vector[0] + s * vector[1], -s * vector[0] + c * vector[1], vector[2]])


def setup(errors=None, **options):
    scene = replace(small_screw(**options), errors=errors or Errors())
    scene = replace(scene, nut=replace(scene.nut, azimuth=0.4))
    layout = ball_layout(scene)
    return scene, layout, draw_geometry_with_errors(scene, layout), np.linspace(0.3, 1.2, layout.z.size)


@pytest.mark.parametrize("errors", [None, FLANK_ERRORS], ids=["exact", "errors"])
@pytest.mark.parametrize("screw", SCREWS)
@pytest.mark.parametrize("side", range(4), ids=SIDES)
def test_derivatives_and_curvatures_are_those_of_the_independent_surface(side, screw, errors):
    """Weingarten's map from the independent derivatives, with the normal taken towards the ball's centre."""
    scene, layout, drawn, gamma = setup(errors, **SCREWS[screw])
    found, curved = surface_derivatives(scene, drawn, side, gamma), principal_curvatures(scene, drawn, side, gamma)
    for i, phi in enumerate(layout.azimuth):
        d, point = derivatives(scene, SIDES[side], phi, gamma[i]), surface(scene, SIDES[side], phi, gamma[i])
        for key, value in d.items():
            assert found[key][i] == pytest.approx(cylindrical(value, phi), rel=1e-12, abs=2e-12), key
        assert found["S"][i] + [0.0, 0.0, layout.z[i]] == pytest.approx(cylindrical(point, phi), abs=1e-16)
        normal = np.cross(d["Sp"], d["Sg"])
        normal *= np.sign(normal @ (layout.centre[i] - point)) / np.linalg.norm(normal)
        first = np.array([[d["Sp"] @ d["Sp"], d["Sp"] @ d["Sg"]], [d["Sp"] @ d["Sg"], d["Sg"] @ d["Sg"]]])
        second = np.array([[d["Spp"] @ normal, d["Spg"] @ normal], [d["Spg"] @ normal, d["Sgg"] @ normal]])
        expected = np.sort(-np.linalg.eigvals(np.linalg.solve(first, second)).real)
        assert curved[i] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("beta", [0.2, np.pi / 4, 1.3])
def test_torus_limit(beta):
    """Zero lead: -1/r_G across; along, the normal curvature of a circle of latitude of the torus."""
    scene, _, drawn, _ = setup(lead=0.0, beta=beta)
    gamma, radius, ball = np.full(6, beta), scene.track.pitch_radius, scene.balls.radius
    for side, groove, sign in ((0, 3.254e-3, 1), (1, 3.254e-3, 1), (2, 3.3e-3, -1), (3, 3.3e-3, -1)):
        along = sign * np.cos(beta) / (radius - sign * ball * np.cos(beta))
        found = principal_curvatures(scene, drawn, side, gamma)
        assert found == pytest.approx(np.tile([-1 / groove, along], (6, 1)), rel=1e-12)


@pytest.mark.parametrize("lead", [0.0, 5e-3, 20e-3, 40e-3])
def test_signs_of_the_curvatures(lead):
    """Concave across both grooves; along the track the screw is convex and the nut concave."""
    scene, _, drawn, _ = setup(lead=lead)
    for side in range(4):
        low, high = principal_curvatures(scene, drawn, side, np.full(6, np.pi / 4))[0]
        assert low == pytest.approx(-1 / (3.254e-3 if side < 2 else 3.3e-3), rel=0.1)
        assert (high > 0.0) == (side < 2)
        assert abs(high) < 0.35 * abs(low)


@pytest.mark.parametrize("side", range(4), ids=SIDES)
def test_hand_and_flank_do_not_matter(side):
    """A left-hand groove is the mirror image of the right-hand one, and SL of SR turned about the radius."""
    gamma = np.full(6, 0.7)

    def curvatures(hand, which):
        scene, _, drawn, _ = setup(hand=hand)
        return principal_curvatures(scene, drawn, which, gamma)

    right = curvatures("right", side)
    assert curvatures("left", side) == pytest.approx(right, rel=1e-12)
    assert curvatures("right", side ^ 1) == pytest.approx(right, rel=1e-12)


def test_constant_offset_of_all_flanks_is_a_change_of_radius():
    side = replace(FLANK_ERRORS.SL, profile=(1e-6,), pitch=())
    drawn = setup(Errors(SL=side))[2]
    assert drawn.groove_radii == pytest.approx([3.253e-3, 3.254e-3, 3.3e-3, 3.3e-3], rel=1e-14)
    assert drawn.profile_coefficients.shape == (4, 0)


def test_a_profile_error_goes_on_around_the_groove_without_a_step_or_a_kink():
    profile, h = np.array([2e-6, -0.6e-6, 0.3e-6]), 1e-3
    gamma = np.arange(-4.0, 4.0, 2 * h)
    rho, slope, bend = groove_radius_with_slopes(gamma, 3e-3, profile)
    before, after = (groove_radius_with_slopes(gamma + d, 3e-3, profile) for d in (-h, h))
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(slope, abs=1e-10)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(bend, abs=1e-7)
    far = gamma[gamma < -2.4]
    assert groove_radius_with_slopes(far + 2 * np.pi, 3e-3, profile) == pytest.approx(
        np.stack([rho, slope, bend])[:, gamma < -2.4]
    )
    here = np.abs(gamma - np.pi / 4) < np.pi / 2
    assert np.array_equal(rho[here], 3e-3 - np.polynomial.Polynomial(profile)(gamma[here]))
