"""The command ``rollbench friction``: solves a friction scene and prints it as a table or as one JSON object."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from compare.commands.solve_output import number
from compare.measure import error_percent
from compare.scenes import friction_scene
from compare.scenes.friction_scene import FrictionScene, LinearScene, RotaryScene
from lowfi.friction.bearing.rotary import SIDES, ball_contacts, bearing_load, inner_torque, motion_problem, source_law
from lowfi.friction.contact.ellipse import Array
from lowfi.friction.contact.laws import Regularised
from lowfi.friction.contact.motion import Motion, Problem, balance_by_root, balance_by_sharpening, least_dissipation
from lowfi.friction.linear.bearing import CONTACTS, directions
from lowfi.friction.linear.chain import ChainResult, prepare, solve
from lowfi.friction.linear.loads import balanced_loads, diagonal_loads, elastic_loads

if TYPE_CHECKING:
    from rich.console import RenderableType

#: Force out of balance over the largest up to which loads count as solved.
BALANCED = 1e-8
#: Semi-axis over ball radius from which Hertz's half-space is doubtful.
LARGE = 0.3
#: Dissipation over that of full sliding below which the loss is an artefact of regularisation.
NOTHING = 1e-6
#: Balls from which loading the compiled kernels pays.
LONG = 60


@dataclass(frozen=True)
class Answer:
    """A solved scene: JSON-ready values, headings and rows of its tables, whether everything converged."""

    data: dict[str, Any]
    tables: Sequence[tuple[str, Sequence[tuple[str, str, str]], Sequence[dict[str, Any]]]]
    lines: Sequence[str]
    converged: bool


def run_friction(scene: str, as_json: bool, show: Callable[..., None], print_json: Callable[[Any], None]) -> int:
    """Solve a shipped friction scene or a file and print it; 1 where it did not converge. Raises InputError."""
    answer = solve_scene(friction_scene.scene(scene))
    if as_json:
        print_json(answer.data)
    else:
        show(*as_table(answer))
    return 0 if answer.converged else 1


def solve_scene(scene: FrictionScene) -> Answer:
    """Solve a friction scene."""
    from compare.commands import friction_screw as friction_screw_command

    if isinstance(scene, RotaryScene):
        return solve_rotary(scene)
    return solve_linear(scene) if isinstance(scene, LinearScene) else friction_screw_command.solve(scene)


def head(scene: FrictionScene, kind: str, status: str, converged: bool) -> dict[str, Any]:
    """What every answer begins with."""
    return {"scene": scene.name, "title": scene.title, "kind": kind, "status": status, "converged": converged}


def balance(power: float, loss: float, bound: float) -> dict[str, Any]:
    """Input power against dissipation [W]; no percentage of less than ``NOTHING`` of what full sliding would spend."""
    off = number(float(error_percent(power, loss))) if loss > NOTHING * bound else None
    return {"input_power_W": number(power), "loss_W": number(loss), "balance_percent": off}


def balance_line(energy: dict[str, Any]) -> str:
    """Sentence on the energy balance."""
    power, loss, off = (
        cell(energy[k], f) for k, f in (("input_power_W", ".6g"), ("loss_W", ".6g"), ("balance_percent", "+.1e"))
    )
    return f"energy: input power {power} W, dissipation {loss} W ({off} %)"


# --- rotary bearing


def rotary_motion(scene: RotaryScene, problem: Problem) -> Motion:
    """Motion under the scene's law: least dissipation for Coulomb, else a root of the balance begun there."""
    first = least_dissipation(problem)
    if scene.law == "coulomb":
        return first
    if scene.law == "regularised":
        return balance_by_root(problem, Regularised(scene.creep), first.q)
    law = source_law(scene.bearing, scene.sharpness, scene.map_step)
    found = balance_by_root(problem, law, first.q)
    return found if found.status == "exact" else balance_by_sharpening(problem, law, first.q)


def rotary_status(loaded: bool, balanced: bool, motion: str) -> str:
    """Text of how a rotary scene ended."""
    if not loaded:
        return "no contact: nothing presses the ball"
    if not balanced:
        return "no balance of the loads found"
    return "no balance of friction found" if motion == "failed" else motion


def solve_rotary(scene: RotaryScene) -> Answer:
    """Loads, motion, losses and torque of one ball."""
    load = bearing_load(scene.bearing, scene.force, scene.displacement, scene.hertz)
    at = ball_contacts(scene.bearing, load, scene.hertz)
    problem = motion_problem(scene.bearing, load, at)
    motion = rotary_motion(scene, problem)
    loaded = bool(np.any(load.force > 0.0))
    converged = loaded and load.converged and motion.status != "failed"
    status = rotary_status(loaded, load.converged, motion.status)
    contacts = [
        {
            "side": side,
            "force_N": number(load.force[i]),
            "angle_deg": number(degrees(load.angle[i])),
            "a_um": number(1e6 * at.a[i]),
            "b_um": number(1e6 * at.b[i]),
            "slide_mm_s": number(1e3 * motion.motion[i, 1]),
            "spin_rad_s": number(motion.motion[i, 2]),
            "friction_N": number(motion.friction.force[i, 1]),
            "moment_Nmm": number(1e3 * motion.friction.moment[i]),
            "loss_W": number(motion.friction.loss[i]),
            "at_rest": bool(motion.rest[i]),
        }
        for i, side in enumerate(SIDES)
        if load.force[i] > 0.0
    ]
    torque, speed = inner_torque(scene.bearing, load, motion), scene.bearing.speed
    energy = balance(torque * speed, motion.loss, float(at.strength.sum()) * abs(speed) * scene.bearing.pitch_radius)
    ball = dict(zip(("orbit_rad_s", "omega_x_rad_s", "omega_y_rad_s"), map(number, motion.q), strict=True))
    by_loss = number(1e3 * motion.loss / speed) if speed != 0.0 else None
    data = head(scene, "rotary bearing", status, converged) | {
        "law": scene.law,
        "hertz": scene.hertz,
        "coupled": False,
        "contacts": contacts,
        "force_sum_N": number(load.force.sum()),
        "ball": ball,
        "torque_Nmm": number(1e3 * torque),
        "torque_from_loss_Nmm": by_loss,
        "energy": energy,
        "solver": {
            "load_imbalance_N": number(load.imbalance),
            "friction_imbalance_N": number(motion.imbalance),
            "load_steps": load.steps,
            "motion_steps": motion.steps,
        },
        "assumed": list(scene.assumed),
        "warnings": size_warnings(at.a[load.force > 0.0], scene.bearing.ball_radius),
    }
    lines = [
        f"sum of contact forces {load.force.sum():.6g} N, friction torque on the inner ring {1e3 * torque:.6g} N mm"
        + ("" if by_loss is None else f" (dissipation over speed: {by_loss:.6g} N mm)"),
        "ball: orbit {:.6g} rad/s, omega_x {:.6g} rad/s, omega_y {:.6g} rad/s".format(*motion.q),
        balance_line(energy),
        f"solver: loads out of balance by {load.imbalance:.1e} N, friction by {motion.imbalance:.1e} N",
        f"law {scene.law}, Hertz constants {scene.hertz}; loads do not depend on friction",
    ]
    return Answer(data, [("per contact", CONTACT_COLUMNS, contacts)], lines, converged)


CONTACT_COLUMNS = (
    ("side", "contact", "s"),
    ("force_N", "force N", ".4f"),
    ("angle_deg", "angle deg", ".4f"),
    ("a_um", "a um", ".1f"),
    ("b_um", "b um", ".1f"),
    ("slide_mm_s", "sliding mm/s", ".4f"),
    ("spin_rad_s", "spin rad/s", ".4f"),
    ("friction_N", "friction N", ".5f"),
    ("moment_Nmm", "moment N mm", ".5f"),
    ("loss_W", "loss W", ".6f"),
    ("at_rest", "at rest", "s"),
)


def size_warnings(a: Array, radius: float) -> list[str]:
    """Warn of contacts that are large against the ball."""
    if a.size == 0 or a.max() <= LARGE * radius:
        return []
    return [f"a contact's semi-axis is {a.max() / radius:.2g} of the ball's radius: Hertz theory no longer holds"]


# --- linear bearing


def linear_loads(scene: LinearScene) -> tuple[Array, Array, float]:
    """Contact angles (N, 4) [rad] and loads (N, 4) [N], and the largest force out of balance over the vertical one.

    Loads equal on each diagonal are an approximation of the source: their imbalance is reported, not judged.
    """
    if scene.distribution == "elastic":
        force, angles = elastic_loads(scene.bearing, scene.angles, scene.vertical, scene.side)
    elif scene.distribution == "balanced":
        angles, force = scene.angles, balanced_loads(scene.angles, scene.vertical, scene.side)
    else:
        rows = diagonal_loads(scene.vertical, scene.side, scene.bearing.contact_angle)
        angles, force = scene.angles, rows
    pushes = force[..., None] * directions(angles)
    carriage = scene.vertical * np.stack([scene.side, -np.ones_like(scene.side)], axis=-1)
    left = np.stack([pushes.sum(axis=1), pushes[:, 2:].sum(axis=1) + carriage])
    return angles, force, float(np.abs(left).max()) / scene.vertical


def ball_rows(
    scene: LinearScene, angles: Array, force: Array, apart: ChainResult, near: ChainResult
) -> list[dict[str, Any]]:
    """One row per ball."""
    rows = []
    for k in range(force.shape[0]):
        row: dict[str, Any] = {"ball": k + 1, "side_force_ratio": number(scene.side[k])}
        row["load_N"] = {c: number(f) for c, f in zip(CONTACTS, force[k], strict=True)}
        row["angle_deg"] = {c: number(degrees(a)) for c, a in zip(CONTACTS, angles[k], strict=True)}
        for name, r in (("apart", apart), ("touching", near)):
            row[f"velocity_{name}_mm_s"] = number(1e3 * r.velocity[k])
            moving = scene.bearing.speed != 0.0
            row[f"deviation_{name}_percent"] = number(100.0 * r.deviation[k]) if moving else None
        row["omega_x_rad_s"], row["omega_y_rad_s"] = (number(w) for w in near.rotation[k])
        row["groove_loss_mW"] = number(1e3 * near.groove_loss[k].sum())
        rows.append(row)
    return rows


def solve_linear(scene: LinearScene) -> Answer:
    """Motion and forces of two or more balls, without contact and in reach of each other."""
    angles, force, left = linear_loads(scene)
    chains = (prepare(scene.bearing, angles, force, touching) for touching in (False, scene.gap <= 0.0))
    apart, near = (solve(chain, fast=force.shape[0] > LONG) for chain in chains)
    loads_good = scene.distribution == "diagonal" or left <= BALANCED
    converged = loads_good and all(r.status == "converged" for r in (apart, near))
    status = near.status if loads_good else "no balance of the loads found"
    balls = ball_rows(scene, angles, force, apart, near)
    sliding = scene.bearing.mu * float(force.sum()) * abs(scene.bearing.speed)
    pairs = [
        {
            "balls": f"{k + 1}-{k + 2}",
            "gap_um": number(1e6 * gap),
            "force_N": number(near.ball_force[k]),
            "loss_mW": number(1e3 * near.ball_loss[k]),
        }
        for k, gap in enumerate(scene.gap)
    ]
    energy = balance(near.power, near.loss, sliding)
    rise = number(float(error_percent(near.loss, apart.loss))) if apart.loss > NOTHING * sliding else None
    semi = np.asarray(scene.bearing.hertz().C_a * np.cbrt(force))
    data = head(scene, scene.kind, status, converged) | {
        "law": "coulomb",
        "distribution": scene.distribution,
        "coupled": False,
        "balls": balls,
        "pairs": pairs,
        "drive_N": number(near.drive),
        "drive_apart_N": number(apart.drive),
        "friction_increase_percent": rise,
        "ball_to_ball_loss_W": number(near.ball_loss.sum()),
        "energy": energy,
        "solver": {
            "load_imbalance": number(left),
            "residual": number(near.residual),
            "lag": number(near.lag),
            "iterations": near.iterations,
        },
        "assumed": list(scene.assumed),
        "warnings": size_warnings(semi, scene.bearing.ball_radius),
    }
    lines = [
        f"force on the carriage {near.drive:.6g} N, {apart.drive:.6g} N with the balls without contact"
        + ("" if rise is None else f": ball-to-ball contact changes it by {rise:+.4g} %"),
        balance_line(energy),
        f"solver: loads out of balance by {left:.1e} of the vertical force, friction by {near.residual:.1e} of its bound",
        f"law coulomb, loads {scene.distribution}; loads do not depend on friction",
    ]
    flat = [row | {f"{c} N": row["load_N"][c] for c in CONTACTS} for row in balls]
    tables = [("per ball", BALL_COLUMNS, flat), ("between balls", PAIR_COLUMNS, pairs)]
    return Answer(data, [t for t in tables if t[2]], lines, converged)


BALL_COLUMNS = (
    ("ball", "ball", "s"),
    *((f"{c} N", f"{c} N", ".3f") for c in CONTACTS),
    ("velocity_apart_mm_s", "v apart mm/s", ".5f"),
    ("deviation_apart_percent", "epsilon apart %", ".4f"),
    ("velocity_touching_mm_s", "v mm/s", ".5f"),
    ("omega_x_rad_s", "omega_x rad/s", ".4f"),
    ("omega_y_rad_s", "omega_y rad/s", ".4f"),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)
PAIR_COLUMNS = (
    ("balls", "balls", "s"),
    ("gap_um", "gap um", ".3f"),
    ("force_N", "force N", ".4f"),
    ("loss_mW", "loss mW", ".5f"),
)


# --- printing


def as_table(answer: Answer) -> list[RenderableType]:
    """The answer for the terminal: tables, results in a few lines, warnings, assumptions."""
    from rich.table import Table

    data = answer.data
    parts: list[Any] = [f"{data['scene']}, {data['kind']}: {data['status']}", data["title"]]
    for title, columns, rows in answer.tables:
        table = Table(title=title, title_justify="left")
        for _, heading, _ in columns:
            table.add_column(heading, justify="right")
        for row in rows:
            table.add_row(*(cell(row[name], form) for name, _, form in columns))
        parts.append(table)
    parts += answer.lines
    for heading, key in (("warning", "warnings"), ("assumed", "assumed"), ("left out", "left_out")):
        parts += [f"{heading}: {line}" for line in data.get(key, ())]
    return parts


def cell(value: Any, form: str) -> str:
    """A value as text."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value) if form == "s" else format(value, form)
