"""Scenes of rolling balls for tests: the linear bearing of Lin's Table 3.3 and the ball screw of Table 3.6, loads given."""

import numpy as np

from rollbench.hifi.rolling import scenes
from rollbench.hifi.rolling.kinematics import RollingBalls

STEEL = scenes.RollingMaterial(210e9, 0.28, 0.1, 0.1)
#: Directions from the ball's centre at BL, BR, TR, TL.
SENSE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def linear_pair(theta_deg: float = 2.0, rho: float = -0.6, *, mated: bool = False, speed: float = 0.01) -> RollingBalls:
    """Two balls under 100 N and opposite side forces; loads in balance at contact angles 45 deg -+ theta below."""
    theta = np.deg2rad(theta_deg)
    layout = scenes.place_balls_on_straight_track(5e-3, 5.6e-3, 2, np.array([0, 0, 1, 1]), speed, np.array([True]))
    angles = 0.25 * np.pi + np.array([-theta, theta, -theta * mated, theta * mated])
    n = SENSE * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    loads = []
    for side in (rho, -rho):
        carriage = 100.0 * np.array([side, -1.0])
        loads.append(np.concatenate([np.linalg.solve(n[:2].T, carriage), np.linalg.solve(n[2:].T, -carriage)]))
    return scenes.create_rolling_balls(layout, STEEL, np.array([n, n]), np.array(loads))


def screw_pair(lead: float = 20e-3, turn: float = 1.0) -> RollingBalls:
    """Two balls of a ball screw under four unequal contact forces each, the nut turning."""
    outward = np.array([-1.0, -1.0, 1.0, 1.0])
    ride = np.where(outward > 0.0, 2.0 * np.pi * turn, 0.0)
    layout = scenes.place_balls_along_helix(2.778e-3, 3.11136e-3, 16.5e-3, lead, 0.25 * np.pi, outward, ride, 2)
    angles = 0.25 * np.pi + np.deg2rad([[0.0, 0.0, 0.0, 0.0], [2.0, 2.0, 0.0, 0.0]])
    across = np.array([-1.0, 1.0, -1.0, 1.0])
    n = np.stack([outward * np.cos(angles), across * np.sin(angles)], axis=-1)
    return scenes.create_rolling_balls(layout, STEEL, n, np.array([[53.4, 18.1, 18.1, 53.4], [54.0, 18.8, 16.9, 53.3]]))
