"""Chains of balls that may roll apart or stand jammed by friction between them: closed form of two balls, search, words."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.friction_oracles import dissipated_power

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.studies.friction.solve import solve_friction_of_named_scene
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.lowfi.friction.contact.laws import contacts_from_values
from rollbench.lowfi.friction.linear.bearing import loads_of_elastic_contacts
from rollbench.lowfi.friction.linear.chain import carriage_drive_force, find_second_equilibrium, prepare_linear_chain
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain

#: Two balls under opposite side forces: deviations [deg] of the contact angles BL, BR, TR, TL, and side force ratios.
DEVIATIONS, SIDE = ((1.9, -0.8, -0.3, -1.2), (-0.3, 0.9, -3.0, -2.7)), (0.89, -0.89)
#: Unknowns of a ball: its speed along the track, and its angular speeds about the two axes across it.
ACROSS = [0, 3, 1]
#: Coefficient between the balls from which on friction can hold what makes it.
LIMIT = 0.035


def two_balls(mu_balls):
    """Bearing, contact angles [rad] and loads [N] of both balls."""
    bearing = replace(source_cases.linear_pair_scene().bearing, mu_balls=mu_balls)
    angles = bearing.contact_angle + np.radians(DEVIATIONS)
    loads, turned = loads_of_elastic_contacts(bearing, angles, 100.0, np.array(SIDE))
    return bearing, turned, loads


def closing(bearing, angles, loads, force):
    """Rate at which the first ball nears the second, over the carriage's speed, where they press with ``force`` [N].

    At a given force the motion of both balls is that of least dissipation, sliding between them included: convex.
    """
    chain, v, size = prepare_linear_chain(bearing, angles, loads), bearing.speed, 1e-5
    rubs, pair, units = chain.friction_contacts, chain.groove.pair, chain.groove.levers[ACROSS]
    at = contacts_from_values(rubs.a.ravel(), rubs.b.ravel(), loads.ravel(), bearing.mu)
    maps = np.zeros((8, 3, 6))
    maps[:4, :, :3], maps[4:, :, 3:] = rubs.maps[..., ACROSS] / units
    slide = np.hstack([pair.first_ball_surface_speeds[:, ACROSS], -pair.second_ball_surface_speeds[:, ACROSS]])
    slide, drives = slide / np.tile(units, 2), rubs.drives.reshape(8, 3) / v
    push, rub = force * np.array([1.0, 0.0, 0.0, -1.0, 0.0, 0.0]), bearing.mu_balls * force

    def total(q):
        d, s = dissipated_power(at, drives + maps @ q, size), slide @ q
        long = np.sqrt(s @ s + size**2)
        gradient = np.einsum("ir,irj->j", d.gradient, maps) + rub * slide.T @ s / long
        return d.power.sum() + push @ q + rub * long, gradient + push

    def bend(q):
        d, s = dissipated_power(at, drives + maps @ q, size), slide @ q
        long = np.sqrt(s @ s + size**2)
        across = (np.eye(2) - np.outer(s, s) / long**2) / long
        return np.einsum("irj,irs,isk->jk", maps, d.hessian, maps) + rub * slide.T @ across @ slide

    start = np.tile(chain.groove.nominal_motion[ACROSS] * units / v, 2)
    found = minimize(total, start, jac=True, hess=bend, method="trust-exact", options={"gtol": 1e-9, "maxiter": 500})
    return float(found.x[0] - found.x[3])


@pytest.mark.parametrize("mu_balls", [0.02, 0.034, 0.036, 0.1, 0.6])
def test_jammed_state_is_found_where_friction_holds_what_makes_it_and_only_there(mu_balls):
    """The pair jams where the closing rate, negative without force, comes back to zero at a force: from 0.035 on."""
    pair = two_balls(mu_balls)
    chain = prepare_linear_chain(*pair)
    found = solve_motion_of_chain(chain)
    assert found.converged
    assert found.ball_force[0] == 0.0
    assert closing(*pair, 0.0) < -1e-3
    other = find_second_equilibrium(chain, found)
    jams = max(closing(*pair, force) for force in (1.0, 4.0, 6.5, 7.0, 7.5)) > 0.0
    assert jams is (mu_balls > LIMIT)
    assert (other is not None) is jams
    if jams:
        assert other.converged
        assert carriage_drive_force(other.wrench) > 1.2 * carriage_drive_force(found.wrench)
        force = other.ball_force[0]
        # just beyond the limit the rate is zero within the oracle's smoothing of friction
        if mu_balls >= 0.1:
            assert closing(*pair, 0.9 * force) > 0.0 > closing(*pair, 1.1 * force)


def chain_file(folder, mu_balls):
    """The two balls as a scene file."""
    text = f"""title = "Two balls that may jam"
kind = "linear chain"
material = {{ youngs_modulus = "210 GPa", poissons_ratio = 0.28 }}
track = {{ contact_angle = "45 deg" }}
grooves = {{ conformity = 0.56 }}
balls = {{ radius = "5 mm" }}
load = {{ vertical_force = "100 N", distribution = "elastic" }}
motion = {{ carriage = "10 mm/s" }}
friction = {{ coefficient = 0.1, balls = {mu_balls} }}
"""
    for angles, side in zip(DEVIATIONS, SIDE, strict=True):
        text += f"[[chain]]\nside_force_ratio = {side}\nangle_deviations = {[f'{x} deg' for x in angles]}\n"
    file = folder / "chain.toml"
    file.write_text(text)
    return str(file)


@pytest.mark.parametrize(("mu_balls", "said"), [(0.1, "up to 8.12 N"), (0.02, "no second"), (0.0, "one only")])
def test_a_typed_chain_says_what_is_known_of_a_jammed_state(mu_balls, said, tmp_path):
    found = solve_friction_of_named_scene(chain_file(tmp_path, mu_balls), FrictionChoices())
    assert found.converged
    assert found.as_json()["pairs"][0]["force_N"] == 0.0
    assert any(said in row.note for row in found.rows())
    assert (found.as_json()["second_state"] is not None) is (mu_balls > LIMIT)
    assert any(w.kind == "jam" for w in found.as_json()["warnings"]) is (mu_balls > LIMIT)
