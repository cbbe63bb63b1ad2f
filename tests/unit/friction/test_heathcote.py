"""Heathcote slip: closed form in pure rolling, bounds, and the whole motion solved again with curved contacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.helpers import small_screw, solved

from rollbench.lowfi.friction.screw.groove import ON_SCREW, contact_axes
from rollbench.lowfi.friction.whole import heathcote, losses
from rollbench.lowfi.friction.whole.contacts import contacts_of_result
from rollbench.lowfi.friction.whole.state import FrictionCase, friction_of_curved_contacts, friction_state
from rollbench.meshes.helix import nominal_groove_radii
from rollbench.meshes.parts import Friction, Motion

MU, TURN = Friction(0.1, 0.1, feedback=False), Motion(10.0)


def rolling(slender, a=2e-3, curve=7.0):
    """One contact of a body that may slide along the path and must roll."""
    x, z, _ = heathcote.hertz_pressure_quadrature()
    rows, added = np.zeros((1, 4, x.size, 2, 4)), np.zeros((1, 4, x.size, 2))
    rows[..., 0, 0] = rows[..., 1, 1] = 1.0
    rows[..., 2] = np.stack([slender * a * z, -a * x], axis=-1)
    added[..., 1] = curve * (a * x) ** 2
    place = np.broadcast_to(np.stack([a * x, slender * a * z], axis=-1), added.shape)
    return heathcote.SurfaceSpeeds(rows, added, place)


@pytest.mark.parametrize("slender", [1.0, 0.3, 0.05])
def test_pure_rolling_has_two_lines_without_slip(slender):
    """Half of the load lies within t0 of the middle, 3 t0 - t0^3 = 1; the loss is 1/5 - t0^3 + 3 t0^5 / 5 of a^2 curve."""
    t0 = float(min(r.real for r in np.roots([1.0, 0.0, -3.0, 1.0]) if r.real > 0.0))
    exact = 0.2 - t0**3 + 0.6 * t0**5
    strength = np.array([[3.0, 0.0, 0.0, 0.0]])
    _, _, power, _ = heathcote.least_dissipation_of_curved(rolling(slender), strength, np.zeros((1, 4)), 7.0 * 4e-6)
    assert power[0] == pytest.approx([3.0 * 7.0 * 4e-6 * exact, 0.0, 0.0, 0.0], rel=0.02)


def curved_power(scene, at, i):
    """Power lost by ball i in each curved contact ``(4,)``, a function of its motion q, by quadrature."""
    path, radii = losses.ball_kinematics(scene, TURN, float(at.ball_radius[i])), nominal_groove_radii(scene)
    maps, drives = path.contact_kinematics(at.normals[i])
    x, z, mass = heathcote.hertz_pressure_quadrature(16, 24)
    along = [contact_axes(normal)[0] for normal in at.normals[i]]

    def power(q):
        motion = maps @ q + drives
        lost = np.zeros(4)
        for s in np.flatnonzero(at.force[i] > 0.0):
            body = path.screw_speed if ON_SCREW[s] else path.nut_speed
            omega = ((q[0] - body) * path.screw_axis_direction + q[1:]) @ along[s]
            curve = omega * 0.25 * (1.0 / at.ball_radius[i] + 1.0 / radii[s])
            a, b = at.a[i, s], at.b[i, s]
            vx = motion[s, 0] + motion[s, 2] * b * z
            vz = motion[s, 1] - motion[s, 2] * a * x + curve * (a * x) ** 2
            lost[s] = 0.1 * at.force[i, s] * float(np.hypot(vx, vz) @ mass)
        return lost

    return power


def with_conformity(scene, conformity):
    radius = conformity * 2.0 * scene.balls.radius
    return replace(scene, screw=replace(scene.screw, groove_radius=radius), nut=replace(scene.nut, groove_radius=radius))


@pytest.mark.parametrize("feedback", [False, True])
@pytest.mark.parametrize(("beta", "conformity", "oversize"), [(15, 0.52, 0.0), (45, 0.52, 0.0), (45, 0.58, 8e-6)])
def test_losses_by_contact_are_those_of_the_motion_solved_again(beta, conformity, oversize, feedback):
    scene = small_screw(2, 0.5, beta=np.radians(beta), force=(0.0, 0.0, 500.0), oversize=oversize, screw="rigid")
    scene, mu = with_conformity(scene, conformity), replace(MU, feedback=feedback)
    case = FrictionCase(scene, solved(scene), mu, TURN)
    state = friction_state(*case)
    flat, found = friction_of_curved_contacts(case, state)
    at = equilibrium_contacts(case, state) if feedback else state.contacts
    lost = np.zeros(4)
    for i in range(2):
        q0 = np.array([flat.orbital_speed[i], *flat.rotation[i]])
        scale = np.array([1e-4, 1e-3, 1e-3, 1e-3]) * np.abs(q0).max()
        power = curved_power(scene, at, i)
        best = minimize(
            lambda y, power=power, q0=q0, scale=scale: 1e3 * power(q0 + scale * y).sum(),
            np.zeros(4),
            method="Nelder-Mead",
            options={"xatol": 1e-5, "fatol": 1e-9, "maxiter": 4000, "adaptive": True},
        )
        lost += power(q0 + scale * best.x)
    assert found.converged
    assert found.loss.sum() == pytest.approx(lost.sum(), rel=1e-3)
    assert found.loss.sum(axis=(0, 2)) == pytest.approx(lost, rel=0.03, abs=1e-3 * lost.sum())


def equilibrium_contacts(case, state):
    """Contacts whose loads balance the friction of curved contacts: forces on ball and screw do not change any more."""
    at, forces = [], []
    solve = heathcote.friction_of_curved_contacts

    def law(groups, starts):
        at[:] = [group.contacts for group in groups]
        return solve(groups, starts)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(heathcote, "friction_of_curved_contacts", law)
        forces[:] = friction_of_curved_contacts(case, state)
    normal = np.einsum("ns,nsi->ni", at[0].force, at[0].normals)
    bare = np.einsum("ns,nsi->ni", case_contacts(case).force, case_contacts(case).normals)
    wrench = forces[1].contact_wrenches(at[0].normals)[..., :3].sum(axis=1)
    assert (normal - wrench)[:, [0, 2]] == pytest.approx(bare[:, [0, 2]], abs=1e-4 * at[0].force.max())
    return at[0]


def case_contacts(case):
    return contacts_of_result(case.scene, case.result, case.member)
