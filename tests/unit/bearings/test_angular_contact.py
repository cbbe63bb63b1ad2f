"""Angular-contact ball bearing under thrust: limits, derivatives, Hertz contact, and the load as an energy's derivative."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.lowfi.bearings import angular_contact

STEEL = (207e9, 0.3)
at_displacement = angular_contact.bearing_state_at_displacement


def bearing(angle: float = 57.0, conformity: tuple[float, float] = (0.52, 0.53)) -> angular_contact.BallBearing:
    return angular_contact.bearing_with_contact_angle(18, 8.73e-3, 55e-3, conformity, np.radians(angle), *STEEL)


def under_thrust(b: angular_contact.BallBearing, load: float) -> angular_contact.BallBearingThrustState:
    return at_displacement(b, b.deflection(load))


@pytest.mark.parametrize("angle", [0.0, 15.0, 25.0, 40.0, 60.0, 90.0])
def test_catalogue_angle_gives_back_itself_and_its_pitch(angle):
    b = bearing(angle)
    assert b.free_angle == pytest.approx(np.radians(angle), abs=1e-7)
    assert b.pitch_diameter == pytest.approx(55e-3, rel=1e-14)
    assert b.centre_distance == pytest.approx(0.05 * 8.73e-3, rel=1e-12)


def test_rigid_limit_keeps_the_angle():
    """A hard bearing does not turn: the load on a ball is F/(Z sin alpha_0), and u sin(alpha_0) its approach."""
    s = under_thrust(replace(bearing(40.0), young=1e7 * 207e9), 5e3)
    assert s.contact_angle == pytest.approx(np.radians(40.0), abs=1e-6)
    assert s.ball_load == pytest.approx(5e3 / (18 * np.sin(np.radians(40.0))), rel=1e-6)
    assert s.displacement * np.sin(np.radians(40.0)) == pytest.approx(float(s.approach), rel=1e-5)


def test_right_angle_is_a_thrust_bearing():
    """Flat discs: the angle stays, F = Z (u/(C_i + C_o))^1.5 with both along-track curvatures those of the ball."""
    b = bearing(90.0)
    (_, inner), (_, outer) = angular_contact.relative_curvatures(b, np.array(b.free_angle))
    assert (inner, outer) == pytest.approx((2.0 / b.ball_diameter,) * 2, rel=1e-14)
    u = np.array([1e-6, 1e-5])
    s = at_displacement(b, u)
    np.testing.assert_allclose(s.contact_angle, np.pi / 2.0, rtol=1e-14)
    np.testing.assert_allclose(s.thrust, 18 * (u / (s.inner_hertz.C + s.outer_hertz.C)) ** 1.5, rtol=1e-12)
    np.testing.assert_allclose(s.stiffness, 1.5 * s.thrust / u, rtol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 15.0, 57.0, 80.0, 90.0])
@pytest.mark.parametrize("u", [1e-6, 2e-5])
def test_stiffness_is_the_derivative(angle, u):
    b, h = bearing(angle), 1e-5 * u
    slope = float(at_displacement(b, u + h).thrust - at_displacement(b, u - h).thrust) / (2.0 * h)
    assert float(at_displacement(b, u).stiffness) == pytest.approx(slope, rel=2e-9)


def test_displacement_and_deflection_identities():
    """2.6 and 2.23 of Smith: approach A (cos a0/cos a - 1), displacement A sin(a - a0)/cos(a)."""
    b = bearing()
    for load in (1e-3, 10.0, 5e3, 2e4):
        s = under_thrust(b, load)
        assert float(s.thrust) == pytest.approx(load, rel=1e-13)
        a, rest, angle = b.centre_distance, b.free_angle, float(s.contact_angle)
        assert float(s.approach) == pytest.approx(a * (np.cos(rest) / np.cos(angle) - 1.0), abs=1e-15)
        assert float(s.displacement) == pytest.approx(a * np.sin(angle - rest) / np.cos(angle), abs=1e-15)
        assert float(s.thrust) == pytest.approx(18 * float(s.ball_load) * np.sin(angle), rel=1e-14)


def test_loose_balls_carry_nothing():
    back = -3.0 * bearing().centre_distance  # where the other shoulder of a deep groove would be
    s = at_displacement(bearing(), np.array([back, -1e-5, 0.0]))
    assert not np.any([s.thrust, s.stiffness, s.ball_load])


def test_many_bearings_under_given_loads_and_back_from_their_rigidity() -> None:
    """Arrays of bearings are single ones, a state under a load is that of its displacement, the conformity comes back."""
    angle = np.radians([15.0, 25.0, 40.0])
    sizes = [12.0, 15.0, 16.0], [4.8e-3, 8e-3, 22.23e-3], [24e-3, 54e-3, 125e-3], [0.515, 0.52, 0.5232]
    balls, ball, pitch, conformity = map(np.array, sizes)
    make = angular_contact.bearing_with_contact_angle
    many = make(balls, ball, pitch, (conformity, conformity), angle, *STEEL)
    load = np.array([50.0, 300.0, 5000.0])
    state = angular_contact.bearing_states_under_thrust(many, load)
    assert state.thrust == pytest.approx(load, rel=1e-9)
    for k in range(3):
        size = float(ball[k]), float(pitch[k]), (float(conformity[k]),) * 2
        alone = make(int(balls[k]), *size, float(angle[k]), *STEEL)
        displacement = alone.deflection(float(load[k]))
        assert float(state.displacement[k]) == pytest.approx(displacement, rel=1e-9)
    begin, conformity_of = (
        make(balls, ball, pitch, (0.54, 0.54), angle, *STEEL),
        angular_contact.conformity_from_pair_rigidity,
    )
    assert conformity_of(begin, load, 2.0 * state.stiffness) == pytest.approx(conformity, rel=1e-7)
    with pytest.raises(ValueError, match="no groove conformity between"):
        conformity_of(begin, load, 20.0 * state.stiffness)
    with pytest.raises(ValueError, match="too large for Hertz contact"):
        angular_contact.bearing_states_under_thrust(many, 1e9 * load)
