"""The Fourier kernel: plain tubes against closed forms, and the compliance between contacts against its own limits."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve
from tests.helpers import relative

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance import fourier
from rollbench.lowfi.compliance import tube as compliance_tube
from rollbench.lowfi.compliance.between import compliance_of_smooth_body, contact_points_and_axes
from rollbench.lowfi.compliance.beyond_hertz import half_space_compliance, sphere_series_expansion
from rollbench.lowfi.compliance.parts import REFINED, reduce_to_compliance_geometry
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Material
from rollbench.meshes.section import tube_section

E, NU = 210e9, 0.28
G = E / (2.0 * (1.0 + NU))
STEEL = Material(E, NU)
SCENE = catalogue.scene("lin-case1")
GEOMETRY = reduce_to_compliance_geometry(SCENE)
BORE, OUTER = 17.4e-3, 24e-3


def tube(elements, rows, length, bore=BORE, outer=OUTER):
    grid = fourier.tube_grid(np.linspace(bore, outer, elements + 1), np.linspace(0.0, length, rows + 1))
    return fourier.BodyOfRevolution(grid, STEEL)


def nothing(body, kind=float):
    """Zeros (rows, columns, 3) at the nodes of a body."""
    return np.zeros((*body.grid.shape, 3), dtype=kind)


def axes_of(rng, count):
    """Two random directions at right angles for every contact."""
    return np.linalg.qr(rng.normal(size=(count, 3, 3)))[0][:, :2]


def solve(body, n, held, force):
    """Motions (rows, columns, 3) by generalised forces of that shape."""
    free = ~held.ravel()
    K = body.harmonic_stiffness(n)[free][:, free]
    q = np.zeros(free.size)
    q[free] = spsolve(sp.csc_matrix(K), force.ravel()[free])
    return q.reshape(force.shape)


def simpson(z):
    """Consistent shares of a uniform line load on nodes of quadratic elements."""
    out = np.zeros_like(z)
    for a in range(0, z.size - 2, 2):
        out[a : a + 3] += (z[a + 2] - z[a]) / 6.0 * np.array([1.0, 4.0, 1.0])
    return out


def plane_ring(n, elements, column, bore=BORE, outer=OUTER):
    """Radial and tangential motion over the pressure cos(n t) on the bore (column 0) or outside (-1), plane strain."""
    body = tube(elements, 1, 5e-3, bore, outer)
    r, z = body.grid.r[0], body.grid.z[:, 0]
    held, force = nothing(body, bool), nothing(body)
    held[..., 2] = True
    held[..., 1] = n == 0
    force[:, column, 0] = (1.0 if column == 0 else -1.0) * fourier.circumference_integral_factor(n) * r[column] * simpson(z)
    return r, solve(body, n, held, force)[1]


def michell(n, a, b, inside):
    """Plane strain of a ring under the pressure cos(n t): functions of r for u_r, u_t (Barber, Elasticity, table 9.1)."""
    kappa = 3.0 - 4.0 * NU

    def stress(r):
        low, high = r ** (n - 2), r ** (-n - 2)
        normal = [n * (1 - n) * low, -n * (n + 1) * high, (2 - n) * (1 + n) * r**n, (2 + n) * (1 - n) * r**-n]
        shear = [(n - 1) * low, -(n + 1) * high, (n + 1) * r**n, (1 - n) * r**-n]
        return [normal, [n * x for x in shear]]

    unit = 1e-2  # lengths in cm, or the powers of r leave nothing of the digits
    load = np.array([-1.0, 0.0, 0.0, 0.0] if inside else [0.0, 0.0, -1.0, 0.0])
    A = np.linalg.solve(np.array(stress(a / unit) + stress(b / unit)), load)

    def motion(r):
        r = r / unit
        radial = [-n * r ** (n - 1), n * r ** (-n - 1), (kappa - n - 1) * r ** (n + 1), (kappa + n - 1) * r ** (1 - n)]
        around = [n * r ** (n - 1), n * r ** (-n - 1), (kappa + n + 1) * r ** (n + 1), -(kappa - n + 1) * r ** (1 - n)]
        return unit * np.stack([A @ np.array(radial), A @ np.array(around)], axis=-1) / (2.0 * G)

    return motion


def test_lame_tube_under_internal_pressure():
    r, q = plane_ring(0, 4, 0)
    exact = (1 + NU) / E * BORE**2 / (OUTER**2 - BORE**2) * ((1 - 2 * NU) * r + OUTER**2 / r)
    np.testing.assert_allclose(q[:, 0], exact, rtol=2e-6)
    assert not q[:, 1:].any()


@pytest.mark.parametrize("column", [0, -1], ids=["bore", "outside"])
@pytest.mark.parametrize("n", [2, 3, 6])
def test_ring_under_a_wave_of_pressure(n, column):
    """Michell's solution; errors fall with the fourth power of the element size."""
    exact = michell(n, BORE, OUTER, column == 0)
    errors = [relative(q[:, :2], exact(r)) for r, q in (plane_ring(n, elements, column) for elements in (4, 8))]
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.25)


def test_cantilever_tube_is_timoshenkos():
    """A force and a moment at the free low end; between two stations away from both ends the mean motions of the sections
    give EI by their tilt and kGA by what their shift adds to it."""
    length, first, last = 0.2, 60e-3, 120e-3
    body = tube(3, 50, length)
    held = nothing(body, bool)
    held[-1] = True
    means = fourier.mean_rigid_motion_matrix(body.grid.r[0], 1)
    force, moment = nothing(body), nothing(body)
    force[0], moment[0] = means.reshape(2, -1, 3)
    z = body.grid.z[:, 0]
    i, j = (int(abs(z - at).argmin()) for at in (first, last))
    section = tube_section(2 * OUTER, 2 * BORE, STEEL)
    shift, tilt = (solve(body, 1, held, moment).reshape(z.size, -1) @ means.T).T
    assert (tilt[i] - tilt[j]) / (z[j] - z[i]) == pytest.approx(1.0 / section.EI, rel=2e-5, abs=0.0)
    assert shift[i] - shift[j] == pytest.approx(-simpson(z[i : j + 1]) @ tilt[i : j + 1], rel=1e-4, abs=0.0)
    shift, tilt = (solve(body, 1, held, force).reshape(z.size, -1) @ means.T).T
    assert tilt[j] - tilt[i] == pytest.approx((z[j] ** 2 - z[i] ** 2) / 2.0 / section.EI, rel=2e-5, abs=0.0)
    sheared = shift[i] - shift[j] + simpson(z[i : j + 1]) @ tilt[i : j + 1]
    assert sheared == pytest.approx((z[j] - z[i]) / section.kGA, rel=5e-4, abs=0.0)


def rigid_fields(body):
    """Amplitudes (rows, columns, 3) of rigid motions by harmonic: shift along, twist; shift across, tilt."""
    r, z = body.grid.r, body.grid.z
    zero, one = np.zeros_like(r), np.ones_like(r)
    return {
        0: [np.stack([zero, zero, one], axis=-1), np.stack([zero, r, zero], axis=-1)],
        1: [np.stack([one, -one, zero], axis=-1), np.stack([z, -z, -r], axis=-1)],
    }


@pytest.mark.parametrize("bore", [0.0, BORE], ids=["shaft", "tube"])
def test_rigid_motions_cost_nothing_and_nothing_else_is_free(bore):
    body = tube(2, 3, 20e-3, bore=bore)
    for n in range(4):
        free = body.freedoms_regular_on_axis(n)
        K = body.harmonic_stiffness(n).toarray()
        for field in rigid_fields(body).get(n, ()):
            q = field.ravel()
            assert abs(K @ q).max() < 1e-12 * abs(K).max() * abs(q).max()
            assert n == 0 or bore or free.reshape(-1, 3)[q.reshape(-1, 3)[:, 1] != 0.0][:, :2].all()
        values = np.linalg.eigvalsh(K[np.ix_(free, free)])
        loose = 2 if n < 2 else 0
        assert abs(values[:loose]).max(initial=0.0) < 1e-12 * values[-1] < values[loose] * 1e-3


BIG = 50e-3


@cache
def own_compliance(width):
    """Own compliance of a radial Gaussian patch on the middle of a big shaft."""
    count, mesh = int(np.ceil(2.6 * BIG / width)), (1.25 * width, 0.6 * width)
    shaft = compliance_tube.SmoothBody(10e-3, BIG, (-40e-3, 40e-3), "both", BIG, width, count, mesh, STEEL)
    points = compliance_tube.ContactPoints(np.array([0.4]), np.zeros(1), np.array([[[1.0, 0, 0], [0, 0, 1.0]]]))
    found = compliance_tube.tube_compliance(shaft, (-5.0 * width, 5.0 * width))
    return compliance_tube.contact_compliance(found, points)[0, 0]


@pytest.mark.slow
def test_half_space_limit():
    """Two widths take out the body; the logarithm of curvature is what is left beside the half space."""
    a, b = sphere_series_expansion(NU)
    widths = 1.5e-3, 3e-3
    found = own_compliance(widths[0]) - own_compliance(widths[1])
    space = half_space_compliance(widths[0], STEEL) - half_space_compliance(widths[1], STEEL)
    curved = (a + 2 * b) / (16 * np.pi * G * BIG) * np.log(widths[0] / widths[1])
    assert found == pytest.approx(space, rel=5e-3, abs=0.0)
    # harmonic 1 keeps the patch's whole resultant: (width / radius)^2 of its own share
    assert found == pytest.approx(space - curved, rel=1e-3, abs=0.0)
    assert own_compliance(widths[1]) == pytest.approx(half_space_compliance(widths[1], STEEL), rel=0.15, abs=0.0)
    closed_form = (1 - NU**2) / (2 * np.sqrt(np.pi) * E * 1e-3)
    assert half_space_compliance(1e-3, STEEL) == pytest.approx(closed_form, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("screw", [False, True], ids=["nut", "screw"])
def test_compliance_of_a_scene_s_contacts_is_symmetric_and_positive_and_converges(screw):
    x, axes = contact_points_and_axes(SCENE, ball_layout(SCENE), screw)
    points = compliance_tube.convert_contacts_to_cylindrical(x, axes)

    def compliance(**changes):
        body = compliance_of_smooth_body(GEOMETRY, screw, replace(REFINED, **changes))
        return compliance_tube.contact_compliance(body, points)

    base = compliance()
    assert np.array_equal(base, base.T)
    values = np.linalg.eigvalsh(base)
    assert values[0] > -1e-12 * values[-1]
    assert relative(compliance(harmonics=1.5), base) < 5e-5
    errors = [relative(compliance(mesh=mesh), compliance(mesh=2.0)) for mesh in (1.0, 1.5)]
    assert errors[0] < 2e-3
    assert errors[1] < 0.4 * errors[0]


def test_line_compliance_is_that_of_the_whole_body():
    """Block elimination along z against a dense solve, held and on springs, there with the motions of the other end."""
    body = tube(2, 4, 20e-3, bore=6e-3)
    columns, count = body.grid.shape[1], body.grid.r.size
    springs = (3e7, 4e4, 5e7, 6e4)
    for held_end, own_springs in ((True, ()), (False, springs)):
        held = nothing(body, bool)
        held[0] = held_end
        found = fourier.grid_line_compliance(body, range(3), held.ravel(), columns - 1, (2, 7), own_springs)
        watched = (3 * (np.arange(2, 7) * columns + columns - 1)[:, None] + np.arange(3)).ravel()
        for n, S in enumerate(S.full_matrix() for S in (found if held_end else found[:2])):
            K = body.harmonic_stiffness(n).toarray()
            if own_springs:
                ends = np.zeros((2, 3 * count))
                ends[:, : 3 * columns] = fourier.mean_rigid_motion_matrix(body.grid.r[0], n)
                K += ends.T @ (np.array(springs[2:] if n == 0 else springs[:2])[:, None] * ends)
            free = ~held.ravel()
            dense = np.zeros_like(K)
            dense[np.ix_(free, free)] = np.linalg.inv(K[np.ix_(free, free)])
            rows = np.eye(3 * count)[watched]
            if own_springs:
                rows = np.concatenate([rows, np.roll(ends, -3 * columns, axis=1)])  # of the high end
            size = np.sqrt(np.diag(S))
            np.testing.assert_allclose(S / size / size[:, None], rows @ dense @ rows.T / size / size[:, None], atol=1e-8)


def far_apart(width, held):
    """Compliance from a far contact to a pair of opposite ones on a shaft, by the kernel and by beam and springs."""
    shaft = compliance_tube.SmoothBody(0.0, 15e-3, (0.0, 0.3), held, 15e-3, width, 8, (2e-3, 1e-3), STEEL)
    z = np.array([0.15, 0.15, 0.25])
    t = np.array([0.3, 0.3 + np.pi, -1.0])
    x = np.column_stack([15e-3 * np.cos(t), 15e-3 * np.sin(t), z])
    axes = axes_of(np.random.default_rng(8), 3)
    points = compliance_tube.convert_contacts_to_cylindrical(x, axes)
    found = compliance_tube.contact_compliance(compliance_tube.tube_compliance(shaft, (0.14, 0.26)), points)
    rigid, section = compliance_tube.contact_motions_by_rigid_motions(x, axes), tube_section(30e-3, 0.0, STEEL)
    beam = compliance_tube.clamped_beam_compliance(rigid, np.repeat(z, 2), shaft.ends, "low", section)
    if held == "section":
        beam = beam + compliance_tube.low_end_spring_compliance(shaft, x, axes)
    return found[:4, 4:], beam[:4, 4:]


def test_shaft_is_a_beam_far_from_its_end():
    """What `low_end_spring_compliance` and `clamped_beam_compliance` stand for.

    A clamped face holds more than a beam's end does.
    The patch's width does not touch the beam."""
    on_springs = relative(*far_apart(0.5e-3, "section"))
    assert on_springs < 4e-3
    assert on_springs < relative(*far_apart(0.5e-3, "low")) < 0.02
    assert relative(*far_apart(2.5e-3, "section")) < 3e-3
