"""Mei's axial-only model of a ball screw (Mei et al. 2003, as Lin 2.4.1 uses it), as a model that rollbench can judge.

The screw is a chain of bars between the balls, the nut is rigid, contact angles are nominal. A screw that moves by u along
its axis at a ball closes the ball's left pair of flanks (SL, NR) by s u and opens the right one (SR, NL) by as much, with
s = sin(contact angle) cos(lead angle); a pair carries (closure / C)^(3/2) by Hertz.
"""

import numpy as np

from rollbench import ModelAnswer, Scene
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.section import screw_section

LEFT_AND_RIGHT = np.array([1.0, -1.0])


def contact_loads(scene: Scene) -> ModelAnswer:
    """Contact loads by bars and springs of fixed direction; errors of the balls count, those of the grooves do not."""
    if any(x.force[0] or x.force[1] or any(x.moment) for x in scene.loads):
        raise ValueError("the model knows axial loads only")
    balls = ball_layout(scene).z
    held = {s.at: value for s in scene.supports for freedom, value in s.fixed if freedom == "uz"}
    nodes = np.unique([*balls, *held, *(x.at for x in scene.loads)])
    at = np.searchsorted(nodes, balls)

    bars = screw_section(scene).EA / np.diff(nodes)
    stiffness = np.zeros((nodes.size, nodes.size))
    for k, bar in enumerate(bars):
        stiffness[k : k + 2, k : k + 2] += bar * np.array([[1.0, -1.0], [-1.0, 1.0]])
    load, u, free = np.zeros(nodes.size), np.zeros(nodes.size), np.ones(nodes.size, dtype=bool)
    for x in scene.loads:
        load[np.searchsorted(nodes, x.at)] += x.force[2]
    for station, value in held.items():
        k = np.searchsorted(nodes, station)
        u[k], free[k] = value, False

    slope = np.sin(scene.track.contact_angle) * np.cos(lead_angle(scene.track))
    C = hertz_without_errors(scene).C
    pair = np.array([C[0] + C[3], C[1] + C[2]])
    growth = np.full(balls.size, scene.errors.balls.oversize)
    for number, error in scene.errors.balls.listed:
        growth[number - 1] += error

    def contacts(u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Loads (n, 2) and stiffnesses (n, 2) of the pairs, and the unbalanced force of every node."""
        closure = np.maximum(2.0 * growth[:, None] + slope * u[at, None] * LEFT_AND_RIGHT, 0.0)
        force = (closure / pair) ** 1.5
        unbalanced = load - stiffness @ u
        np.subtract.at(unbalanced, at, slope * force @ LEFT_AND_RIGHT)
        return force, 1.5 * np.sqrt(closure / pair) / pair, np.where(free, unbalanced, 0.0)

    # begin where all balls would carry the same load
    share = abs(load.sum()) / (balls.size * slope)
    u[free] += np.sign(load.sum()) * share ** (2.0 / 3.0) * pair[0] / slope
    for _ in range(100):
        force, tangent, unbalanced = contacts(u)
        if np.abs(unbalanced).max() <= 1e-12 * max(force.max(), np.abs(load).max()):
            break
        matrix = stiffness.copy()
        np.add.at(matrix, (at, at), slope**2 * tangent.sum(axis=1))
        matrix[np.diag_indices_from(matrix)] += 1e-12 * matrix.diagonal().max()
        u[free] += np.linalg.solve(matrix[np.ix_(free, free)], unbalanced[free])
    else:
        raise ValueError("the iteration does not converge")

    loads = np.zeros((balls.size, 4))
    loads[:, [0, 3]], loads[:, [1, 2]] = force[:, :1], force[:, 1:]
    moved = np.zeros(6)
    moved[2] = np.interp(scene.nut.position, nodes, u)
    return ModelAnswer(loads, displacement=moved)
