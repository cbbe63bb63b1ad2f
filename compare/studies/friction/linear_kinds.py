"""Friction of linear ball bearings: two or more balls of a row, both as if far apart and with balls that touch."""

from __future__ import annotations

from typing import Any

import numpy as np

from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.quantities import json_number
from rollbench.compare.results.data import FrictionBall
from rollbench.compare.scenes.friction_kinds.bearings import LinearBearingScene
from rollbench.compare.studies.friction import answer
from rollbench.compare.text.printing import Column
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
    balls = []
    for k in range(force.shape[0]):
        entries: dict[str, Any] = {"index": ..., "side_force_ratio": json_number(scene.side[k])}
        entries |= answer.ball_loads_json(bearing.CONTACTS, force[k], angles[k])
        for name, r in (("apart", apart), ("touching", touching)):
            entries[f"velocity_{name}_mm_s"] = json_number(1e3 * r.q[k, 0])
            deviation = linear_chain.velocity_deviations(scene.bearing, r)[k] if scene.bearing.speed != 0.0 else None
            entries[f"deviation_{name}_percent"] = None if deviation is None else json_number(100.0 * deviation)
        entries |= {"rotation_rad_s": ..., "groove_loss_mW": json_number(1e3 * touching.groove_loss[k].sum())}
        rotation = [*(json_number(w) for w in touching.q[k, [3, 1]]), 0.0]
        balls.append(FrictionBall(index=k + 1, rotation=rotation, entries=entries))
    return tuple(balls)


def json_rows_of_neighbouring_balls(scene: LinearBearingScene, touching: ChainMotion) -> list[dict[str, Any]]:
    """Return a JSON row for each pair of neighbouring balls: their gap, and force and friction loss in their contact.

    ``touching``: solution with balls that touch.
    """
    return [
        {
            "balls": f"{k + 1}-{k + 2}",
            "gap_um": json_number(1e6 * gap),
            "force_N": json_number(touching.ball_force[k]),
            "loss_mW": json_number(1e3 * touching.ball_loss[k]),
        }
        for k, gap in enumerate(scene.gap)
    ]


def solve_friction_of_linear_bearing(scene: LinearBearingScene) -> answer.FrictionAnswer:
    """Solve motion and friction of a row of balls in a linear bearing, both far apart and with balls that touch."""
    angles, force, left = linear_bearing_loads(scene)
    chains = [
        linear_chain.prepare_linear_chain(scene.bearing, angles, force, touching) for touching in (False, scene.gap <= 0.0)
    ]
    apart, near = (solve_motion_of_chain(chain) for chain in chains)
    second = linear_chain.find_second_equilibrium(chains[1], near) if near.converged else None
    loads_good = scene.distribution == "diagonal" or left <= BALANCED
    converged = loads_good and apart.converged and near.converged
    balls = balls_of_linear_bearing(scene, angles, force, apart, near)
    pairs = json_rows_of_neighbouring_balls(scene, near)
    bound = scene.bearing.mu * float(force.sum()) * abs(scene.bearing.speed)
    ball_loss = float(near.ball_loss.sum())
    semi = np.asarray(scene.bearing.contact_hertz_constants().C_a * np.cbrt(force))
    motion_status = "converged" if near.converged else "not converged"
    status = motion_status if loads_good else "no balance of the loads found"
    residual = near.largest_unbalanced_force / (chains[1].largest_friction_bound or 1.0)
    drive, drive_apart = (linear_chain.carriage_drive_force(motion.wrench) for motion in (near, apart))
    states = sentence_on_jammed_equilibrium(chains[1], second)
    record = answer.friction_of_parts(
        scene,
        status,
        converged,
        {
            "law": "coulomb",
            "distribution": scene.distribution,
            "coupled": False,
            "balls": ...,
            "pairs": pairs,
            "drive_N": json_number(drive),
            "drive_apart_N": json_number(drive_apart),
            "second_state": None if second is None else jammed_equilibrium_as_json(near, second),
            "second_state_words": states,
            **answer.ball_to_ball_contact_effect(near.input_power, near.loss, apart.loss, ball_loss, bound),
            "solver.load_imbalance": json_number(left),
            "solver.residual": json_number(residual),
            "solver.lag": json_number(near.largest_gap_violation / (abs(scene.bearing.speed) or 1.0)),
            "solver.iterations": near.steps,
        },
        loss=near.loss,
        balls=balls,
        warnings=(*contact_size_warnings(semi, scene.bearing.ball_radius), *jammed_state_warnings(near, second)),
    )
    rise = answer.loss_increase_percent(near.loss, apart.loss, bound)
    force_line = f"{drive:.6g} N drive the carriage, {drive_apart:.6g} N with the balls apart"
    lines = [
        ("force", force_line + ("" if rise is None else f": ball-to-ball contact changes it by {rise:+.4g} %")),
        ("states", states),
        answer.line_on_energy_balance(near.input_power, near.loss),
        ("solver", f"loads out of balance by {left:.1e} of the vertical force, friction by {residual:.1e} of its bound"),
        ("law", f"coulomb, loads {scene.distribution}; loads do not depend on friction"),
    ]
    tables = [
        ("per ball", BALL_COLUMNS, [answer.terminal_ball_row(bearing.CONTACTS, ball.as_json()) for ball in balls]),
        ("between balls", PAIR_COLUMNS, pairs),
    ]
    return answer.FrictionAnswer(record, [t for t in tables if t[2]], lines)


def jammed_equilibrium_as_json(touching: ChainMotion, jammed: ChainMotion) -> dict[str, Any]:
    """Return the second equilibrium of a row of touching balls, in which friction jams them, as JSON.

    The JSON values are the force that drives the carriage, and those forces between neighbouring balls that differ from
    the first equilibrium. ``touching``: first equilibrium, in which the balls roll; ``jammed``: the second one.
    """
    apart = np.abs(jammed.ball_force - touching.ball_force)
    other = np.flatnonzero(apart > linear_chain.ANOTHER * apart.max())
    pairs = [{"balls": f"{k + 1}-{k + 2}", "force_N": json_number(jammed.ball_force[k])} for k in other]
    return {"drive_N": json_number(linear_chain.carriage_drive_force(jammed.wrench)), "pairs": pairs}


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


#: Columns of the terminal's table of balls; v is the velocity of a ball, "apart" means balls too far apart to touch.
BALL_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    *((f"{c} N", f"{c} N", ".3f") for c in bearing.CONTACTS),
    ("velocity_apart_mm_s", "v apart mm/s", ".5f"),
    ("deviation_apart_percent", "v apart above half the carriage's %", ".4f"),
    ("velocity_touching_mm_s", "v mm/s", ".5f"),
    *((f"omega {n}", f"omega_{n} rad/s", ".4f") for n in "xy"),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)
#: Columns of the terminal's table of pairs of neighbouring balls.
PAIR_COLUMNS: tuple[Column, ...] = (
    ("balls", "balls", "s"),
    ("gap_um", "gap um", ".3f"),
    ("force_N", "force N", ".4f"),
    ("loss_mW", "loss mW", ".5f"),
)
