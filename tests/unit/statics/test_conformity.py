"""What conformity does to a contact, against one solved on a grid with exact gaps, which shares nothing with the models."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import fftconvolve
from scipy.sparse.linalg import LinearOperator, cg
from tests.helpers import relative, small_screw, solved, with_ingredients

from rollbench.lowfi.hertz import hertz_constants
from rollbench.lowfi.statics import contacts
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors, SideErrors

RADIUS, GROOVE, ALONG, MODULUS = 4e-3, 4.4e-3, 1 / 4e-3 + 41.0, 1.139e11


def constants(across, along=ALONG):
    return hertz_constants(np.array(across), np.array(along), MODULUS)


class Contact:
    """Half space under piecewise constant pressure (Love's rectangles); coordinates are arcs, gaps along ball's normals."""

    def __init__(self, force, cells=18):
        c = constants(1 / RADIUS - 1 / GROOVE)
        self.a, self.b = float(c.C_a * np.cbrt(force)), float(c.C_b * np.cbrt(force))
        self.approach = float(c.C * force ** (2 / 3))
        dx, dy = 1.25 * self.a / cells, 1.25 * self.b / cells
        steps = np.arange(-2 * cells, 2 * cells + 1)
        X, Y = np.meshgrid(steps * dx, steps * dy, indexing="ij")

        def corner(x, y):
            return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

        corners = [(sx, sy) for sx in (1, -1) for sy in (1, -1)]
        self.K = sum(sx * sy * corner(X + 0.5 * sx * dx, Y + 0.5 * sy * dy) for sx, sy in corners) / (np.pi * MODULUS)
        self.area = dx * dy
        self.x, self.y = np.meshgrid(steps[cells:-cells] * dx, steps[cells:-cells] * dy, indexing="ij")

    def moved_where(self, active):
        """Motions of the points that touch, by pressures on them."""

        def moved(pressures):
            return np.where(active, fftconvolve(self.K, pressures.reshape(active.shape), mode="valid"), 0.0).ravel()

        return LinearOperator((active.size, active.size), moved)

    def pressure(self, closed):
        """p >= 0 with K p >= closed, by conjugate gradients on the points that touch."""
        p = np.sqrt(np.maximum(1 - (self.x / self.a) ** 2 - (self.y / self.b) ** 2, 0.0)) * self.approach / self.K.max()
        active = p > 0.0
        for _ in range(60):
            wanted = np.where(active, closed, 0.0).ravel()
            p = cg(self.moved_where(active), wanted, p.ravel(), rtol=1e-10)[0].reshape(p.shape)
            after = (active & (p > 0.0)) | (~active & (closed > fftconvolve(self.K, p, mode="valid")))
            p = np.where(after, np.maximum(p, 0.0), 0.0)
            if (after == active).all():
                return p
            active = after
        raise AssertionError("the contact does not settle")

    def gap(self, ball=RADIUS):
        """Distance of ball and groove along the ball's normals: exact arcs across about fixed centres, a parabola along."""
        theta, offset = self.x / RADIUS, GROOVE - RADIUS
        across = np.sqrt(GROOVE**2 - (offset * np.sin(theta)) ** 2) - offset * np.cos(theta) - ball
        return across + 0.5 * ALONG * self.y**2

    def upright(self, groove):
        """The same along the contact's normal, at places fixed in space: a groove that grows moves its arc's points."""
        across = np.sqrt(groove**2 - self.x**2) - np.sqrt(RADIUS**2 - self.x**2) - (GROOVE - RADIUS)
        return across + 0.5 * ALONG * self.y**2

    def load(self, approach, gap, oblique=True):
        close = np.cos(self.x / RADIUS) * np.cos(self.y / RADIUS) if oblique else np.ones_like(self.x)
        return float((self.pressure(approach * close - gap) * close).sum()) * self.area

    def same_load(self, wanted, gap, guess, oblique=True):
        """Approach that gives a load: secants on the load to the power 2/3, nearly a straight line."""
        d0, d1 = guess, 1.001 * guess
        f0 = self.load(d0, gap, oblique) ** (2 / 3)
        for _ in range(4):
            f1 = self.load(d1, gap, oblique) ** (2 / 3)
            if abs(f1 / wanted ** (2 / 3) - 1) < 1e-9:
                break
            d0, d1, f0 = d1, d1 + (wanted ** (2 / 3) - f1) * (d1 - d0) / (f1 - f0), f1
        return d1


@pytest.mark.parametrize("force", [60.0, 500.0])
def test_growth_of_the_ball_is_more_than_an_approach(force):
    one, e = Contact(force), 2e-6
    load = one.load(one.approach - e, one.gap(ball=RADIUS + e))
    gain = (one.same_load(load, one.gap(), one.approach) - (one.approach - e)) / e - 1.0
    assert gain == pytest.approx((one.a**2 + one.b**2) / (6 * RADIUS**2), rel=0.03, abs=0.0)
    # Hertz's law at the larger ball's curvatures says the same
    c, d = (constants(1 / r - 1 / GROOVE, ALONG + 1 / r - 1 / RADIUS).C for r in (RADIUS, RADIUS + 1e-9))
    assert gain == pytest.approx(float(c - d) * force ** (2 / 3) / 1e-9, rel=0.03, abs=0.0)


def test_error_of_the_grooves_radius_counts_across_only():
    one, e = Contact(500.0), 2e-6
    load = one.load(one.approach - e, one.upright(GROOVE - e), oblique=False)
    gain = (one.same_load(load, one.upright(GROOVE), one.approach, oblique=False) - (one.approach - e)) / e - 1.0
    c, d = (constants(1 / RADIUS - 1 / r).C for r in (GROOVE, GROOVE - 1e-9))
    assert float(c - d) * 500.0 ** (2 / 3) / 1e-9 == pytest.approx(one.a**2 / (6 * GROOVE**2), rel=1e-3, abs=0.0)
    # the arcs, steeper than their parabolas, make the ellipse a little shorter
    assert 0.93 < gain / (one.a**2 / (6 * GROOVE**2)) < 1.0


def test_oblique_pressure_softens_the_contact():
    one = Contact(500.0)
    gap = 0.5 * (1 / RADIUS - 1 / GROOVE) * one.x**2 + 0.5 * ALONG * one.y**2
    load = one.load(one.approach, gap, oblique=False)
    assert load == pytest.approx(500.0, rel=1e-3)
    increase = one.same_load(load, gap, 1.008 * one.approach) / one.approach - 1.0
    coefficient = float(contacts.oblique_pressure_coefficient(constants(1 / RADIUS - 1 / GROOVE), RADIUS))
    assert increase == pytest.approx(coefficient * 500.0 ** (4 / 3) / one.approach, rel=0.02, abs=0.0)


def changes_of(scene):
    drawn = draw_geometry_with_errors(scene, ball_layout(scene))
    return drawn, contacts.curvature_changes(scene, drawn, drawn.ball_radii)


def test_every_contact_has_its_own_radii():
    scene = small_screw(oversize=3e-6)
    balls = BallErrors(oversize=3e-6, listed=((2, 2e-6),))
    scene = replace(scene, errors=replace(scene.errors, balls=balls, NR=SideErrors(profile=(4e-6,))))
    (drawn, changes), r = changes_of(scene), scene.balls.radius
    for ball, larger in ((0, 3e-6), (1, 5e-6)):
        assert changes[ball, :2] == pytest.approx(1 / (r + larger) - 1 / r, rel=1e-12)
    across = 1 / (r + 3e-6) - 1 / r - (1 / (3.3e-3 - 4e-6) - 1 / 3.3e-3)
    assert changes[0, 3] == pytest.approx([across, 1 / (r + 3e-6) - 1 / r], rel=1e-12)
    others = np.stack([drawn.ball_radii, drawn.ball_radii + 1e-6])
    both = contacts.hertz_constants_by_scene_choice(scene, drawn, others)
    for found, radii in zip(both, others, strict=True):
        assert found == pytest.approx(contacts.hertz_with_errors(scene, drawn, radii).C, rel=1e-14)
    assert (both[1] <= both[0]).all()  # a larger ball conforms more


def test_profile_counts_by_its_curvature():
    """An offset k gamma^2 beside the angle beta: curvature of rho - offset, (rho - rho'')/rho^2 and smaller terms."""
    scene = replace(small_screw(), errors=Errors(SL=SideErrors(profile=(0.0, 0.0, 5e-6))))
    _, changes = changes_of(scene)
    rho, beta = 3.254e-3, scene.track.contact_angle
    radius, bend = rho - 5e-6 * beta**2, -10e-6
    assert changes[0, 0, 0] == pytest.approx(-((radius - bend) / radius**2 - 1 / rho), rel=1e-2)
    assert not changes[:, 1:].any()
    assert not changes[:, 0, 1].any()


def test_a_preload_is_worth_more_than_error_free_parts_say():
    """By 3/2 of the share of (1): the squeeze of a single ball between rigid rings."""
    scene = small_screw(oversize=5e-6, force=(0.0, 0.0, 100.0))
    old = with_ingredients(scene, hertz="error-free")
    ratio = solved(scene).load.mean() / solved(old).load.mean() - 1.0
    hertz, force = contacts.hertz_without_errors(scene), float(solved(old).load.mean())
    axes = (hertz.C_a**2 + hertz.C_b**2).mean() * force ** (2 / 3)
    assert ratio == pytest.approx(1.5 * axes / (6 * scene.balls.radius**2), rel=0.05)
    tight = small_screw(force=(0.0, 0.0, 1000.0))
    assert relative(solved(tight).load, solved(with_ingredients(tight, hertz="error-free")).load) < 1e-12
