"""Friction of linear ball bearings: two or more balls of a row, both as if far apart and with balls that touch."""

from __future__ import annotations

import numpy as np

from rollbench.compare.cases.lin.kinds.bearings import LinearBearingScene
from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.quantities import json_number
from rollbench.compare.results.friction import FrictionBall
from rollbench.compare.results.friction_parts import BallPair, FrictionOfLinearBearing, JammedState
from rollbench.compare.studies.friction import answer
from rollbench.lowfi.friction.linear import bearing
from rollbench.lowfi.friction.linear import chain as linear_chain
from rollbench.lowfi.friction.screw.chain import ChainMotion, solve_motion_of_chain
from rollbench.lowfi.statics.validity import contact_size_warnings
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array

#: Largest unbalanced force over the largest force, for loads that count as solved.
BALANCED = 1e-8


def linear_bearing_loads(scene: LinearBearingScene) -> tuple[Array, Array, float]:
    """Return contact angles and contact loads of the N balls of a linear bearing, then the largest unbalanced force.

    If the scene asks for the load distribution "diagonal", opposite contacts of a ball, such as bottom left and top right,
    carry equal loads, which is an approximation of Lin's thesis. The unbalanced force that this approximation leaves is
    reported, but does not count as a failure.

    Returns
    -------
    Array
        Contact angles, (N, 4) [rad].
    Array
        Contact loads, (N, 4) [N].
    float
        Largest unbalanced force over the vertical force.

    Raises
    ------
    SceneNotCoveredError
        If contact angles that follow the loads allow no equilibrium.
    """
    if scene.distribution == "elastic":
        try:
            force, angles = bearing.loads_of_elastic_contacts(scene.bearing, scene.angles, scene.vertical, scene.side)
        except ArithmeticError as error:
            advice = 'change the forces on the balls, or take distribution = "balanced"'
            raise SceneNotCoveredError(scene.name, "load", str(error), advice) from error
    elif scene.distribution == "balanced":
        angles, force = scene.angles, bearing.loads_in_equilibrium(scene.angles, scene.vertical, scene.side)
    else:
        angles = scene.angles
        force = bearing.loads_equal_on_diagonals(scene.vertical, scene.side, scene.bearing.contact_angle)
    pushes = force[..., None] * bearing.contact_directions(angles)
    carriage = scene.vertical * np.stack([scene.side, -np.ones_like(scene.side)], axis=-1)
    left = np.stack([pushes.sum(axis=1), pushes[:, 2:].sum(axis=1) + carriage])
    return angles, force, float(np.abs(left).max()) / scene.vertical


def balls_of_linear_bearing(
    scene: LinearBearingScene, angles: Array, force: Array, apart: ChainMotion, touching: ChainMotion
) -> tuple[FrictionBall, ...]:
    """Return the balls of a linear bearing: contact loads, speed, rotation and friction loss of each.

    ``angles``: contact angles (N, 4) [rad] at the four contacts of N balls; ``force``: contact loads (N, 4) [N];
    ``apart`` and ``touching``: solutions with the balls far apart, and with balls that touch. Each ball has the speeds
    of both solutions, but rotation and loss with touching balls only.
    """
    deviations = [
        linear_chain.velocity_deviations(scene.bearing, r) if scene.bearing.speed != 0.0 else [None] * len(force)
        for r in (apart, touching)
    ]
    return tuple(
        FrictionBall(
            index=k + 1,
            side_force_ratio=float(scene.side[k]),
            **answer.ball_loads(bearing.CONTACTS, force[k], angles[k]),
            velocity_apart=apart.q[k, 0],
            deviation_apart=deviations[0][k],
            velocity_touching=touching.q[k, 0],
            deviation_touching=deviations[1][k],
            rotation=[*(json_number(w) for w in touching.q[k, [3, 1]]), 0.0],
            groove_loss=float(touching.groove_loss[k].sum()),
            keys=BALL_KEYS,
        )
        for k in range(force.shape[0])
    )


#: Keys of the JSON of a ball, and of the friction of a linear bearing.
BALL_KEYS = (
    *("index", "side_force_ratio", *answer.LOAD_KEYS, "velocity_apart_mm_s", "deviation_apart_percent"),
    *("velocity_touching_mm_s", "deviation_touching_percent", "rotation_rad_s", "groove_loss_mW"),
)
KEYS = (
    *("law", "distribution", "coupled", "balls", "pairs", "drive_N", "drive_apart_N", "second_state"),
    *("second_state_words", *answer.CONTACT_EFFECT_KEYS),
    *("solver.load_imbalance", "solver.residual", "solver.lag", "solver.iterations"),
)


def solve_friction_of_linear_bearing(scene: LinearBearingScene) -> FrictionOfLinearBearing:
    """Solve motion and friction of a row of balls in a linear bearing, both far apart and with balls that touch."""
    angles, force, left = linear_bearing_loads(scene)
    chains = [
        linear_chain.prepare_linear_chain(scene.bearing, angles, force, touching) for touching in (False, scene.gap <= 0.0)
    ]
    apart, near = (solve_motion_of_chain(chain) for chain in chains)
    second = linear_chain.find_second_equilibrium(chains[1], near) if near.converged else None
    loads_good = scene.distribution == "diagonal" or left <= BALANCED
    converged = loads_good and apart.converged and near.converged
    pairs = (
        BallPair(balls=f"{k + 1}-{k + 2}", gap=float(gap), force=near.ball_force[k], loss=near.ball_loss[k])
        for k, gap in enumerate(scene.gap)
    )
    bound = scene.bearing.mu * float(force.sum()) * abs(scene.bearing.speed)
    semi = np.asarray(scene.bearing.contact_hertz_constants().C_a * np.cbrt(force))
    motion_status = "converged" if near.converged else "not converged"
    drive, drive_apart = (linear_chain.carriage_drive_force(motion.wrench) for motion in (near, apart))
    return answer.friction_of_parts(
        FrictionOfLinearBearing,
        scene,
        motion_status if loads_good else "no balance of the loads found",
        converged,
        KEYS,
        law="coulomb",
        distribution=scene.distribution,
        coupled=False,
        balls=balls_of_linear_bearing(scene, angles, force, apart, near),
        pairs=tuple(pairs),
        carriage_force=drive,
        carriage_force_apart=drive_apart,
        second_state=None if second is None else jammed_state(near, second),
        second_state_words=sentence_on_jammed_equilibrium(chains[1], second),
        **answer.ball_to_ball_contact_effect(near.input_power, near.loss, apart.loss, float(near.ball_loss.sum()), bound),
        load_imbalance=left,
        motion_residual=near.largest_unbalanced_force / (chains[1].largest_friction_bound or 1.0),
        lag=near.largest_gap_violation / (abs(scene.bearing.speed) or 1.0),
        iterations=near.steps,
        warnings=(*contact_size_warnings(semi, scene.bearing.ball_radius), *jammed_state_warnings(near, second)),
    )


def jammed_state(touching: ChainMotion, jammed: ChainMotion) -> JammedState:
    """Return the second equilibrium of a row of touching balls, in which friction jams them.

    It has the force that drives the carriage, and those forces between neighbouring balls that differ from the first
    equilibrium. ``touching``: first equilibrium, in which the balls roll; ``jammed``: the second one.
    """
    apart = np.abs(jammed.ball_force - touching.ball_force)
    other = np.flatnonzero(apart > linear_chain.ANOTHER * apart.max())
    pairs = (BallPair(balls=f"{k + 1}-{k + 2}", force=jammed.ball_force[k]) for k in other)
    return JammedState(carriage_force=linear_chain.carriage_drive_force(jammed.wrench), pairs=tuple(pairs))


def sentence_on_jammed_equilibrium(chain: linear_chain.LinearBallChain, jammed: ChainMotion | None) -> str:
    """Return a sentence on whether a second equilibrium was found, in which friction jams the row of balls.

    ``chain``: the touching balls; ``jammed``: their second equilibrium, None if none was found.
    """
    if not linear_chain.may_have_several_equilibria(chain):
        return "one only: no balls in reach of each other, or no friction between them"
    if jammed is None:
        return (
            "no second, jammed state was found, from three starts and from states with more friction between balls, "
            f"{' and '.join(f'{mu:g}' for mu in linear_chain.RISEN)}: a search, no proof"
        )
    force, drive = float(jammed.ball_force.max()), linear_chain.carriage_drive_force(jammed.wrench)
    return f"there is a second, jammed state: up to {force:.3g} N between balls, {drive:.3g} N drive the carriage"


def jammed_state_warnings(touching: ChainMotion, jammed: ChainMotion | None) -> list[ResultWarning]:
    """Return a warning if the balls have a second equilibrium, in which friction jams them; the list is empty otherwise.

    ``touching``: first equilibrium of the touching balls; ``jammed``: the second one, None if none was found.
    """
    if jammed is None:
        return []
    most, base = jammed.ball_force.max(), touching.ball_force.max()
    jams, rolls = (linear_chain.carriage_drive_force(motion.wrench) for motion in (jammed, touching))
    brief = "friction between balls allows a second state"
    text = (
        f"{brief}: they press on each other by up to {most:.4g} N instead of "
        f"{base:.4g} N, and the carriage needs {jams:.6g} N instead of "
        f"{rolls:.6g} N; which state occurs depends on the motion before"
    )
    return [ResultWarning("jam", text, brief)]
