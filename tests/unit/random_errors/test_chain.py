"""The chain of balls against minimisation by brute force, closed forms, a second model and its own conditions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.as_source.liu import chain as chains
from rollbench.lowfi.as_source.mei import solve_mei
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.section import screw_section

ANGLE, LEAD, A = np.radians(45.0), np.radians(3.64), 0.191e-3
SHORT = chains.BallScrewChain(5, 7e9, 2e-10, A, ANGLE, LEAD)
ERRORS = 1e-6 * np.array([-1.5, 0.7, 2.0, -2.0, 0.3])
LONG = chains.BallScrewChain(78, 7.1e9, 3.9e-12, A, ANGLE, LEAD)


def long_errors(seed=1, half=2e-6, balls=78):
    return np.random.default_rng(seed).uniform(-half, half, balls)


def solved(load=500.0, **changes):
    """The long chain with some changes, without errors."""
    chain = replace(LONG, **changes)
    return chain, chains.solve_ball_screw(chain, np.zeros(chain.balls), load)


def energy(u, chain, errors, load):
    """Energy [N um] of motions [um], written from the geometry; constant and exact contact angle."""
    v = u * np.cos(chain.lead_angle) * 1e-6
    if chain.law == "constant":
        approach = errors + v * np.sin(ANGLE)
    else:
        approach = np.hypot(A * np.sin(ANGLE) + v, A * np.cos(ANGLE)) - A + errors
    stored = 0.4 * chain.stiffness * np.maximum(approach, 0.0) ** 2.5
    bars = (1e-6 * np.diff(u)) ** 2 / (2.0 * chain.compliance)
    return 1e6 * (stored.sum() + bars.sum() - 1e-6 * load * u[0])


@pytest.mark.parametrize("law", ["constant", "exact"])
@pytest.mark.parametrize("load", [5.0, 60.0, 900.0])
def test_minimum_by_brute_force(law, load):
    chain = replace(SHORT, law=law)
    options = {"xatol": 1e-9, "fatol": 1e-13, "maxiter": 20000, "maxfev": 40000, "adaptive": True}
    found = minimize(energy, np.full(5, 6.0), (chain, ERRORS, load), method="Nelder-Mead", options=options)
    s = chains.solve_ball_screw(chain, ERRORS, load)
    assert s.converged
    assert energy(1e6 * s.motion, chain, ERRORS, load) <= found.fun + 1e-9 * abs(found.fun)
    # loose balls ride on the chain: their motion is determined too
    assert 1e6 * s.motion == pytest.approx(found.x, abs=2e-4)


def implicit_load(u, error, chain):
    """Contact load and sine of the contact angle by bracketing (10) and (14)."""
    v = u * np.cos(chain.lead_angle)

    def sine(d):
        return np.sqrt(1.0 - ((A - error) * np.cos(ANGLE) / (A - error + d)) ** 2)

    if error + v * np.sin(ANGLE) <= 0.0:
        return 0.0, np.sin(ANGLE)
    d = brentq(lambda d: d - error - v * sine(d), 0.0, 1e-4, xtol=1e-20, rtol=1e-14)
    return chain.stiffness * d**1.5, sine(d)


@pytest.mark.parametrize("load", [5.0, 60.0, 900.0])
def test_source_s_implicit_angle(load):
    chain = replace(SHORT, law="implicit")
    s = chains.solve_ball_screw(chain, ERRORS, load)
    q, sine = np.array([implicit_load(u, e, chain) for u, e in zip(s.motion, ERRORS, strict=True)]).T
    assert s.load == pytest.approx(q, rel=1e-10, abs=1e-10 * load)
    tail = np.cumsum((q * sine * np.cos(LEAD))[::-1])[::-1]
    assert tail[0] == pytest.approx(load, rel=1e-9)
    assert -np.diff(s.motion) == pytest.approx(chain.compliance * tail[1:], rel=1e-9)


@pytest.mark.parametrize("law", chains.LAWS)
@pytest.mark.parametrize("load", [30.0, 300.0, 3000.0])
def test_conditions_of_the_minimum(law, load):
    """Equilibrium, compatibility, no tension, no gap at a loaded ball."""
    chain, e = replace(LONG, law=law), long_errors()
    s = chains.solve_ball_screw(chain, e, load)
    force = chains.force_of_balls(chain, s.motion, e).axial
    tail = np.cumsum(force[::-1])[::-1]
    assert tail[0] == pytest.approx(load, rel=1e-9)
    assert -np.diff(s.motion) == pytest.approx(chain.compliance * tail[1:], rel=1e-8, abs=1e-18)
    free = chains.axial_motion_at_touch(chain, e)
    assert np.array_equal(s.load > 0.0, s.motion > free)
    assert s.load.min() >= 0.0
    assert 0 < s.loaded_balls <= 78


def test_rigid_bodies_share_equally_and_load_as_hertz():
    chain, s = solved(5000.0, compliance=0.0, law="constant")
    assert s.load == pytest.approx(np.full(78, 5000.0 / 78 / chain.approach_per_motion), rel=1e-12)
    # F = 78 slope K (slope u)^1.5
    assert s.stiffness == pytest.approx(1.5 * 5000.0 / s.displacement, rel=1e-12)
    _, soft = solved(5000.0, compliance=1e-20, law="constant")
    assert soft.load == pytest.approx(s.load, rel=1e-6)


def test_ball_joins_at_its_load():
    e = np.zeros(78)
    e[32] = -2e-6
    load = chains.load_at_which_ball_is_loaded(LONG, e, 32, 5000.0)
    below, above = (chains.solve_ball_screw(LONG, e, share * load).load[32] for share in (0.999, 1.001))
    assert below == 0.0 < above
    assert chains.load_at_which_ball_is_loaded(LONG, -e, 32, 5000.0) == 0.0
    with pytest.raises(ValueError, match="not loaded"):
        chains.load_at_which_ball_is_loaded(LONG, e, 32, 0.9 * load)
    # rigid, constant angle: the other 77 balls close the gap
    rigid = replace(LONG, compliance=0.0, law="constant")
    by_hand = 77 * rigid.approach_per_motion * rigid.stiffness * 2e-6**1.5
    assert chains.load_at_which_ball_is_loaded(rigid, e, 32, 5000.0) == pytest.approx(by_hand, rel=1e-9)


def test_same_as_mei_with_a_rigid_nut():
    """The axial model on scenes, of beams' sections, agrees where it is the same: constant angle, one elastic body."""
    s = scene("lin-case1")
    other, layout, constants = solve_mei(s), ball_layout(s), hertz_without_errors(s).C
    spacing = float(np.diff(np.sort(layout.z))[0])
    stiffness = float((constants[0] + constants[3]) ** -1.5)
    bar, angles = spacing / screw_section(s).EA, (s.track.contact_angle, lead_angle(s.track))
    chain = chains.BallScrewChain(32, stiffness, bar, A, *angles, "constant")
    ours = chains.solve_ball_screw(chain, np.zeros(32), 5000.0).load
    assert ours == pytest.approx(np.sort(other.load[:, 0])[::-1], rel=1e-8)


def test_uneven_spacing_is_a_chain_with_a_ball_left_out():
    """A ball so small that it stays loose leaves a chain with one gap of two spacings."""
    e = long_errors(5)
    e[40] = -20e-6
    whole = chains.solve_ball_screw(LONG, e, 3000.0)
    kept, mean = np.delete(np.arange(78), 40), 77.0 / 76.0
    other = replace(LONG, balls=77, compliance=LONG.compliance * mean, spacing=tuple(np.diff(kept) / mean))
    found = chains.solve_ball_screw(other, e[kept], 3000.0)
    assert found.load == pytest.approx(whole.load[kept], rel=1e-9, abs=1e-9)
    assert found.stiffness == pytest.approx(whole.stiffness, rel=1e-9)
    with pytest.raises(ValueError, match="76"):
        replace(other, spacing=(1.0,))
