"""Gradient and Hessian of the kernels against complex steps of an energy written independently in numpy."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import FLANK_ERRORS, dense, prepared, small_screw, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.as_source import element_stiffness
from rollbench.lowfi.statics.kernel import newton
from rollbench.lowfi.statics.kernel_types import Slopes
from rollbench.lowfi.statics.shape import shape_polynomials
from rollbench.meshes.parts import SIDES, BallErrors
from rollbench.meshes.section import contact_stations

DIRECTION = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
CASES = {
    "lin-case1": lambda: catalogue.scene("lin-case1"),
    "lin-case3-offset": lambda: catalogue.scene("lin-case3-offset"),
    "lin-combined": lambda: catalogue.scene("lin-combined"),
    "source partition": lambda: with_ingredients(catalogue.scene("lin-case2"), partition="source"),
    "uneven flanks": lambda: replace(
        small_screw(oversize=3e-6, force=(200.0, 100.0, 900.0), moment=(3.0, -2.0, 0.0)),
        errors=replace(FLANK_ERRORS, balls=BallErrors(oversize=3e-6)),
    ),
    "left hand bearing": lambda: small_screw(lead=0.0, hand="left", oversize=2e-6, force=(300.0, 0.0, 0.0)),
}


def product(x, matrix):
    """x @ matrix for complex x, part by part: as fast as real ones."""
    return x.real @ matrix + 1j * (x.imag @ matrix) if np.iscomplexobj(x) else x @ matrix


class Model:
    """E(q, p) of beam, loads and contacts, for complex q (..., nodes, 6) and p (..., balls, 2); gradient by hand."""

    def __init__(self, ready):
        problem = ready.problem
        scene, layout, drawn = problem.scene, problem.layout, problem.drawn
        self.nodes, self.load, self.drawn = problem.nodes, problem.load, drawn
        self.count, self.n6 = layout.z.size, 6 * problem.nodes.size
        self.K = np.zeros((self.n6, self.n6))
        for e, length in enumerate(np.diff(self.nodes)):
            self.K[6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += element_stiffness(length, problem.section)
        self.C = problem.C
        self.radius = np.array([scene.screw.groove_radius] * 2 + [scene.nut.groove_radius] * 2) - [
            (scene.errors.side(s).profile or (0.0,))[0] if drawn.profile.shape[1] == 0 else 0.0 for s in SIDES
        ]
        self.B = np.zeros((self.count, 4, 2, self.n6))
        stations = contact_stations(scene, layout)
        for i in range(self.count):
            axes = np.stack([layout.radial[i], layout.binormal[i]])
            for s in range(2):
                centre = layout.centre[i] + drawn.centre[i, s] @ axes
                self.B[i, s] = axes @ self.motion_of_point(centre, stations[i, s], problem)
        self.B = self.B.reshape(8 * self.count, -1)

    def motion_of_point(self, point, station, problem):
        """Displacement (3, 6 n) of a point that moves with the section at ``station``: u + theta x r."""
        interpolated = np.zeros((6, self.n6))
        j = int(np.abs(self.nodes - station).argmin())
        if problem.scene.ingredients.partition == "nodal":
            station = self.nodes[j]
            interpolated[:, 6 * j : 6 * j + 6] = np.eye(6)
        else:
            j -= int(self.nodes[j] > station)
            length = self.nodes[j + 1] - self.nodes[j]
            xi = np.array([(station - self.nodes[j]) / length])
            interpolated[:, 6 * j : 6 * j + 12] = shape_polynomials(xi, np.array([length]), problem.section)[0]
        x, y, z = point - [0.0, 0.0, station]
        return interpolated[:3] + np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]]) @ interpolated[3:]

    def flat(self, q):
        return q.reshape(*q.shape[:-2], self.n6)

    def contacts(self, q, p):
        """Approach (..., N, 4) and the unit vector from ball to groove (..., N, 4, 2)."""
        moved = product(self.flat(q), self.B.T).reshape(*p.shape[:-1], 4, 2)
        w = p[..., None, :] - self.drawn.centre - moved
        if self.drawn.profile.shape[1] == 0:
            size = np.sqrt((w * w).sum(-1))
            return self.drawn.ball_radius[:, None] - self.radius + size, w / size[..., None]
        gamma = np.arctan(DIRECTION[:, 1] * w[..., 1] / (DIRECTION[:, 0] * w[..., 0]))
        for _ in range(40):  # closest point: (A - w) . A' = 0 by a fixed point that contracts by w rho' / rho2
            rho, slope = self.profile(gamma)
            u = DIRECTION * w
            along = u[..., 0] * np.cos(gamma) + u[..., 1] * np.sin(gamma)
            across = u[..., 1] * np.cos(gamma) - u[..., 0] * np.sin(gamma)
            gamma = gamma + ((along - rho) * slope + across * rho) / (along * rho)
        a = DIRECTION * np.stack([rho * np.cos(gamma), rho * np.sin(gamma)], -1)
        d = np.sqrt(((a - w) ** 2).sum(-1))
        return self.drawn.ball_radius[:, None] - d, (a - w) / d[..., None]

    def profile(self, gamma):
        powers = np.stack([gamma**k for k in range(self.drawn.profile.shape[1])], -1)
        slopes = np.stack([k * gamma ** max(k - 1, 0) for k in range(self.drawn.profile.shape[1])], -1)
        return (self.radius - (powers * self.drawn.profile).sum(-1), -(slopes * self.drawn.profile).sum(-1))

    def energy(self, q, p):
        delta, _ = self.contacts(q, p)
        touching = np.where(delta.real > 0.0, delta, 0.0)
        beam = 0.5 * (self.flat(q) * product(self.flat(q), self.K)).sum(-1)
        return beam - (self.load * q).sum((-2, -1)) + (0.4 * self.C**-1.5 * touching**2.5).sum((-2, -1))

    def gradient(self, q, p):
        """By q (..., 6 n) and p (..., 2 N), flat."""
        delta, normal = self.contacts(q, p)
        force = (np.where(delta.real > 0.0, delta, 0.0) / self.C) ** 1.5
        pull = force[..., None] * normal
        by_q = product(self.flat(q), self.K) - self.load.ravel() - product(pull.reshape(*p.shape[:-2], -1), self.B)
        return np.concatenate([by_q, pull.sum(-2).reshape(*p.shape[:-2], -1)], -1)

    def complex_steps(self, function, q, p, h=1e-40):
        """Derivatives of a function of (q, p) by each of its arguments, in the rows."""
        x = np.concatenate([q.ravel(), p.ravel()])
        x = x + 1j * h * np.eye(x.size)
        return function(x[:, : self.n6].reshape(-1, *q.shape), x[:, self.n6 :].reshape(-1, *p.shape)).imag / h


def at_random_state(scene, seed):
    """Kernel's gradient, Hessian, and the state, with the shaft bent and moved by some micrometres.

    A contact of less than 1e-3 N is avoided: the test's own approach, a difference of radii, has few digits there.
    """
    ready = prepared(scene)
    rng = np.random.default_rng(seed)
    q, d = ready.state.q, ready.state.d
    arm = scene.track.pitch_radius
    q[0] = rng.normal(0.0, 3e-6, 6) / [1, 1, 1, 20 * arm, 20 * arm, arm]
    d[:] = rng.normal(0.0, 2e-7, d.shape) / [1, 1, 1, 100 * arm, 100 * arm, arm]
    out = Slopes(np.zeros((q.shape[0], 6)), np.zeros((ready.problem.C.shape[0], 4, 4)))
    energy, scale = newton.evaluate(ready.given, ready.state, out)
    if ready.force[ready.force > 0.0].min() < 1e-3:
        return at_random_state(scene, seed + 10)
    band = np.empty((q.size, ready.problem.half_bandwidth + 1))
    newton.assemble(band, *ready.given, out.hessians, 0.0, arm)
    return ready, energy, scale, out.gradient, dense(band)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("case", CASES)
def test_gradient(case, seed):
    scene = CASES[case]()
    ready, energy, scale, gradient, _ = at_random_state(scene, seed)
    model, q, p = Model(ready), ready.state.q, ready.state.p
    assert (ready.force > 0.0).any()
    assert energy == pytest.approx(model.energy(q, p), rel=1e-9)
    steps = model.complex_steps(model.energy, q, p)
    unit = np.tile([1.0, 1.0, 1.0] + [scene.track.pitch_radius] * 3, len(q))
    assert np.abs((gradient.ravel() - steps[: model.n6]) / unit).max() < 1e-10 * scale
    loaded = np.repeat(ready.force.any(axis=1), 2)
    assert np.abs(steps[model.n6 :][loaded]).max() < 1e-10 * scale  # the centres are eliminated: dE/dp = 0


@pytest.mark.parametrize("case", CASES)
def test_hessian(case):
    """Schur complement of the full Hessian over the balls' centres, at the free freedoms."""
    scene = CASES[case]()
    ready, _, scale, _, hessian = at_random_state(scene, 0)
    model, q, p = Model(ready), ready.state.q, ready.state.p
    by_hand = model.gradient(q, p)
    assert np.abs(by_hand - model.complex_steps(model.energy, q, p)).max() < 1e-10 * scale
    full = model.complex_steps(model.gradient, q, p)
    n = model.n6
    loaded = n + np.flatnonzero(np.repeat(ready.force.any(axis=1), 2))
    expected = full[:n, :n] - full[:n, loaded] @ np.linalg.solve(full[np.ix_(loaded, loaded)], full[loaded, :n])
    free = ~ready.problem.fixed.ravel()
    unit = np.tile([1.0, 1.0, 1.0] + [scene.track.pitch_radius] * 3, len(q))
    unit = np.outer(unit, unit)[np.ix_(free, free)]

    def scaled(matrix):
        return matrix[np.ix_(free, free)] / unit

    # the beam is up to 1e5 times as stiff as the contacts: allow for its round-off, and hold the rest to the contacts
    allowed = 1e-9 * np.abs(scaled(expected - model.K)).max() + 1e-15 * np.abs(scaled(model.K)).max()
    assert np.abs(scaled(hessian) - scaled(expected)).max() < allowed
    assert np.array_equal(hessian[~free][:, ~free], np.eye((~free).sum()))
    assert not hessian[~free][:, free].any()
