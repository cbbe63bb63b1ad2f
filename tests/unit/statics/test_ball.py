"""One ball in its grooves: the eliminated centre against scipy's minimum of an independently written energy."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.helpers import FLANK_ERRORS, four_flank_problem, small_screw

from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice
from rollbench.lowfi.statics.rolling_elements import ball_equilibrium
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, BallErrors, Errors, SideErrors

DIRECTION = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
UNEVEN = Errors(**{name: SideErrors(profile=FLANK_ERRORS.side(name).profile) for name in SIDES})
#: Oversize [m], standard deviation of the flanks' motions [m], and the numbers of contacts that must be met.
STATES = {"tight": (8e-6, 1e-6, {4}), "between": (3e-6, 4e-6, {3, 4}), "loose": (-1e-6, 6e-6, {0, 2, 3})}
PROFILES = {"arcs": Errors(), "uneven": UNEVEN}


class Ball:
    """The first ball of a small screw: arrays for the solver, and plain numbers for the test's own energy."""

    def __init__(self, profile, oversize):
        scene = small_screw(count=2)
        self.scene = replace(scene, errors=replace(PROFILES[profile], balls=BallErrors(oversize=oversize)))
        self.drawn = draw_geometry_with_errors(self.scene, ball_layout(self.scene))
        self.C = hertz_constants_by_scene_choice(self.scene, self.drawn)
        self.balls, self.C = four_flank_problem(self.scene).balls.one_by_one().take(np.array([0])), self.C[0]
        self.radius = self.scene.balls.radius + oversize

    def settle(self, shift, taking_part=(0, 1, 2, 3), floor=1e-9):
        """Energy, centre and contacts of the solver."""
        used = np.isin(np.arange(4), taking_part)[None]
        x, contacts, energy = ball_equilibrium(replace(self.balls, used=used), shift[None], np.array([floor]))
        return float(energy[0]), x[0, :2], contacts

    def gap(self, p, shift, side):
        """Distance from the moved centre to the flank's closest point, gamma by Newton on a sampled guess."""
        sx, sz = DIRECTION[side]
        body = self.scene.screw if side < 2 else self.scene.nut
        slack, beta = body.groove_radius - self.scene.balls.radius, np.pi / 4
        w = p - shift[side] + slack * np.array([sx * np.cos(beta), sz * np.sin(beta)])
        coefficients = self.scene.errors.side(SIDES[side]).profile

        def distance(gamma):
            rho = body.groove_radius - sum(c * gamma**k for k, c in enumerate(coefficients))
            return np.hypot(w[0] - sx * rho * np.cos(gamma), w[1] - sz * rho * np.sin(gamma))

        middle = np.arctan2(sz * w[1], sx * w[0])
        if not coefficients:
            return distance(middle)
        half = 0.3
        for _ in range(3):  # the distance is even about its minimum: three parabolas are plenty
            low, mid, high = (distance(middle + t * half) for t in (-1, 0, 1))
            middle += half * (low - high) / (2 * (low - 2 * mid + high))
            half *= 0.1
        return distance(middle)

    def energy(self, p, shift):
        delta = np.array([max(self.radius - self.gap(p, shift, s), 0.0) for s in range(4)])
        return float(np.sum(0.4 * self.C**-1.5 * delta**2.5))

    def minimum(self, shift, start):
        """Least energy and its place, from simplexes about two starting points."""
        options = {"xatol": 1e-9, "fatol": 1e-14, "maxiter": 4000, "maxfev": 4000}
        micro = 1e-6
        unit = max(self.energy(start + np.array([0.0, 2e-6]), shift), 1e-9)
        found = [
            minimize(lambda x: self.energy(micro * x, shift) / unit, x0, method="Nelder-Mead", options=options)
            for x0 in (start / micro + 0.2, np.zeros(2))
        ]
        best = min(found, key=lambda x: x.fun)
        return best.fun * unit, best.x * micro


ball = cache(Ball)
each_state = pytest.mark.parametrize(("profile", "state"), list(product(PROFILES, STATES)))


def random_shifts(size, count, seed=5):
    shifts = np.zeros((count, 4, 2))
    shifts[:, :2] = np.random.default_rng(seed).normal(0.0, size, (count, 2, 2))
    return shifts


@each_state
def test_minimum_of_the_energy(state, profile):
    oversize, size, counts_to_meet = STATES[state]
    b, counts = ball(profile, oversize), set()
    for shift in random_shifts(size, 8):
        energy, p, contacts = b.settle(shift)
        counts.add(int((contacts.force > 0).sum()))
        least, place = b.minimum(shift, p)
        assert energy == pytest.approx(least, rel=1e-9, abs=1e-15)
        if energy > 0.0:
            assert p == pytest.approx(place, abs=2e-5 * 1e-6)
    assert counts >= counts_to_meet


@pytest.mark.parametrize(("oversize", "pressed"), [(8e-6, 0.0), (0.0, 1e-12), (0.0, 1e-9), (0.0, 1e-6), (0.0, 1e-4)])
def test_force_grows_with_the_power_three_halves_and_a_flank_that_takes_no_part_has_none(oversize, pressed):
    """Pressed along its own line: F = (approach / (C_SL + C_NR))^1.5, whatever its size."""
    b, shift = ball("arcs", oversize), np.zeros((4, 2))
    shift[0] = pressed * np.sqrt([0.5, 0.5])
    expected = ((pressed + 2.0 * oversize) / (b.C[0] + b.C[3])) ** 1.5
    found = b.settle(shift, taking_part=(0, 3), floor=0.0)[2].force[0]
    assert found == pytest.approx([expected, 0.0, 0.0, expected], rel=1e-6 if pressed else 1e-9)
