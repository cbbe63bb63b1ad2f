"""Solves friction scenes of rotary bearings: one ball, and a four-point against a double-row bearing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from rollbench.compare.quantities import number
from rollbench.compare.scenes.friction_kinds.bearings import BearingBallScene, BearingPairScene
from rollbench.compare.studies.friction import answer
from rollbench.compare.studies.friction.screw_kinds import screw_warnings, sliding
from rollbench.compare.text.printing import cell
from rollbench.lowfi.friction.bearing import rotary
from rollbench.lowfi.friction.bearing.pairs import BearingCase, BearingState, bearing_states, free_motion
from rollbench.lowfi.friction.contact.ellipse import Contacts
from rollbench.lowfi.friction.contact.laws import Regularised
from rollbench.lowfi.friction.contact.motion import (
    Motion,
    Problem,
    balance_by_root,
    balance_by_sharpening,
    least_dissipation,
    without_friction,
)
from rollbench.lowfi.friction.contact.rings import Settled
from rollbench.lowfi.friction.screw.motion import source_law
from rollbench.lowfi.statics.validity import size_warnings


def ball_motion(scene: BearingBallScene, problem: Problem) -> Motion:
    """Motion under the scene's law: least dissipation for Coulomb, else a root of the balance begun there."""
    first = least_dissipation(problem)
    if scene.law == "coulomb":
        return first
    if scene.law == "regularised":
        return balance_by_root(problem, Regularised(scene.creep), first.q)
    law = source_law(scene.bearing, scene.sharpness, scene.map_step)
    found = balance_by_root(problem, law, first.q)
    return found if found.status == "exact" else balance_by_sharpening(problem, law, first.q)


def ball_status(loaded: bool, balanced: bool, motion: str) -> str:
    """How the scene of one ball ended, in words."""
    if not loaded:
        return "no contact: nothing presses the ball"
    if not balanced:
        return "no balance of the loads found"
    return "no balance of friction found" if motion == "failed" else "converged"


def ball_row(load: Settled, at: Contacts, motion: Motion) -> dict[str, Any]:
    """The ball; x of a contact lies across its groove, z along it. Loads and friction lie in planes of symmetry."""
    f = motion.friction
    return (
        {"index": 1}
        | answer.load_row(rotary.SIDES, load.force, load.angle)
        | {
            "semi_axis_across_um": answer.by_side(rotary.SIDES, 1e6 * at.a),
            "semi_axis_along_um": answer.by_side(rotary.SIDES, 1e6 * at.b),
        }
        | answer.motion_row(np.append(motion.q, 0.0))
        | answer.rubbing_row(rotary.SIDES, motion.motion, f.force, f.moment, f.loss, motion.rest)
    )


def contact_rows(ball: dict[str, Any]) -> list[dict[str, Any]]:
    """The loaded contacts of a ball for the terminal."""
    size = ("load_N", "contact_angle_deg", "semi_axis_across_um", "semi_axis_along_um")
    rows = []
    for side in (s for s in rotary.SIDES if ball["load_N"][s] > 0.0):
        row = {name: ball[name][side] for name in (*size, "spin_rad_s", "moment_Nmm", "loss_mW", "at_rest")}
        rows.append({"side": side, "slide": ball["sliding_mm_s"][side][1], "along": ball["friction_N"][side][1]} | row)
    return rows


CONTACT_COLUMNS = (
    ("side", "contact", "s"),
    ("load_N", "force N", ".4f"),
    ("contact_angle_deg", "angle deg", ".4f"),
    ("semi_axis_across_um", "a um", ".1f"),
    ("semi_axis_along_um", "b um", ".1f"),
    ("slide", "sliding mm/s", ".4f"),
    ("spin_rad_s", "spin rad/s", ".4f"),
    ("along", "friction N", ".5f"),
    ("moment_Nmm", "moment N mm", ".5f"),
    ("loss_mW", "loss mW", ".4f"),
    ("at_rest", "at rest", "s"),
)


def solve_ball(scene: BearingBallScene) -> answer.FrictionAnswer:
    """Loads, motion, losses and torque of one ball."""
    b = scene.bearing
    load = rotary.bearing_load(b, scene.force, scene.displacement)
    rough = replace(b, mu=b.mu or 1.0)
    at = rotary.ball_contacts(rough, load)
    motion = ball_motion(scene, rotary.motion_problem(rough, load, at))
    if b.mu == 0.0:
        motion = without_friction(motion)
    held = load.force > 0.0
    converged = bool(held.any()) and load.converged and motion.status != "failed"
    ball, torque, speed = ball_row(load, at, motion), rotary.inner_torque(b, load, motion), b.screw_speed
    power = answer.energy(torque * speed, motion.loss, float(at.strength.sum()) * abs(speed) * b.pitch_radius)
    by_loss = number(1e3 * motion.loss / abs(speed)) if speed != 0.0 else None
    data = answer.head(scene, ball_status(bool(held.any()), load.converged, motion.status), converged) | {
        "law": scene.law,
        "hertz": answer.hertz_word(b.hertz),
        "coupled": False,
        "balls": [ball],
        "load_sum_N": number(load.force.sum()),
        "torque": {"friction_torque_Nmm": by_loss, "driving_torque_on_screw_Nmm": number(1e3 * torque)},
        "energy": power,
        "solver": {
            "load_imbalance_N": number(load.left),
            "friction_imbalance_N": number(motion.imbalance),
            "load_steps": load.steps,
            "motion_steps": motion.steps,
            "motion": motion.status,
        },
        "warnings": size_warnings(at.a[held], b.ball_radius),
    }
    return answer.FrictionAnswer(data, [("per contact", CONTACT_COLUMNS, contact_rows(ball))], ball_lines(data), converged)


def ball_lines(data: dict[str, Any]) -> list[answer.Line]:
    """The results of one ball in a few lines."""
    (ball,), torque = data["balls"], data["torque"]
    by_loss = torque["friction_torque_Nmm"]
    return [
        (
            "torque",
            f"{torque['driving_torque_on_screw_Nmm']:.6g} N mm turn the inner ring"
            + ("" if by_loss is None else f" (dissipation over speed: {by_loss:.6g} N mm)"),
        ),
        ("loads", f"sum of contact forces {data['load_sum_N']:.6g} N; they do not depend on friction"),
        (
            "ball",
            "orbit {:.6g} rad/s, omega_x {:.6g} rad/s, omega_y {:.6g} rad/s".format(
                ball["orbit_rad_s"], *ball["rotation_rad_s"][:2]
            ),
        ),
        answer.energy_line(data["energy"]),
        answer.solver_line(data["solver"]),
        ("law", f"{data['law']}, Hertz constants {data['hertz']}"),
    ]


# --- bearings in pairs


def rubs(case: BearingCase, state: BearingState) -> bool:
    """Whether friction spends more than round-off."""
    return float(state.loss.sum()) > answer.NOTHING * sliding(case.groove, state.load.force)


def bearing_data(case: BearingCase, states: list[BearingState]) -> dict[str, Any]:
    """A bearing's torques [N mm] over the angles and the largest over the smallest."""
    torque = [1e3 * s.torque for s in states]
    all_rub = all(rubs(case, s) for s in states)
    return {
        "friction_torque_Nmm": [number(t) for t in torque],
        "balls_beyond_two_contacts": [int(np.sum(s.points > 2)) for s in states],
        "largest_over_smallest": number(max(torque) / min(torque)) if all_rub else None,
        "converged": [s.converged for s in states],
    }


def loose(scene: BearingPairScene) -> list[str]:
    """Motions of an inner ring that the force drives and no contact resists, by bearing and load angle."""
    out = []
    for name, case in (("four-point", scene.four_point), ("double row", scene.double_row)):
        for angle in scene.angle:
            free = free_motion(case, float(angle))
            if free:
                where = f"load at {np.degrees(angle):.4g} deg"
                out.append(f"{name} bearing, {where}: {free}: no contact resists it, and the force drives it")
    return out


def solve_bearings(scene: BearingPairScene) -> answer.FrictionAnswer:
    """Friction torque of both bearings over the angle of the load; the energy is the mean over all states."""
    case, angle = scene.four_point, [number(a) for a in np.degrees(scene.angle)]
    common = {
        "law": "coulomb",
        "hertz": answer.hertz_word(case.groove.hertz),
        "coupled": False,
        "force_N": number(case.force),
        "tilt": case.tilt,
        "load_angle_deg": angle,
    }
    mechanisms = loose(scene)
    if mechanisms:
        others = f" (and {len(mechanisms) - 1} more)" if len(mechanisms) > 1 else ""
        status = f"no equilibrium: {mechanisms[0]}{others}"
        return answer.FrictionAnswer(answer.head(scene, status, False) | common | {"warnings": []}, [], [], False)
    return _bearing_answer(scene, common)


def _bearing_answer(scene: BearingPairScene, common: dict[str, Any]) -> answer.FrictionAnswer:
    cases = scene.four_point, scene.double_row
    by_case = [bearing_states(case, scene.angle) for case in cases]
    four, double = (bearing_data(case, states) for case, states in zip(cases, by_case, strict=True))
    good = [f and d for f, d in zip(four["converged"], double["converged"], strict=True)]
    status = "converged" if all(good) else f"{good.count(False)} of {len(good)} load angles did not converge"
    ratios = [number(f.torque / d.torque) if rubs(cases[1], d) else None for f, d in zip(*by_case, strict=True)]
    states = [(c, s) for c, one in zip(cases, by_case, strict=True) for s in one]
    power, loss, bound = (
        float(np.mean(v))
        for v in (
            [s.input_power for _, s in states],
            [s.loss.sum() for _, s in states],
            [sliding(c.groove, s.load.force) for c, s in states],
        )
    )
    spent = answer.energy(power, loss, bound)
    large = [
        w.of(name)
        for name, c, one in zip(("four-point", "double row"), cases, by_case, strict=True)
        for w in screw_warnings(c.groove, np.stack([s.load.force for s in one]))
    ]
    solver = {"load_imbalance_N": number(max(s.load.left for _, s in states))}
    data = answer.head(scene, status, all(good)) | common | {"four_point": four, "double_row": double}
    data |= {"four_over_double": ratios, "energy": spent, "solver": solver, "warnings": large}
    columns = zip(
        common["load_angle_deg"],
        four["friction_torque_Nmm"],
        double["friction_torque_Nmm"],
        ratios,
        four["balls_beyond_two_contacts"],
        good,
        strict=True,
    )
    rows = [dict(zip((name for name, _, _ in BEARING_COLUMNS), row, strict=True)) for row in columns]
    return answer.FrictionAnswer(data, [("over the load's angle", BEARING_COLUMNS, rows)], bearing_lines(data), all(good))


def bearing_lines(data: dict[str, Any]) -> list[answer.Line]:
    """The results of both bearings in a few lines."""
    four, double = (cell(data[name]["largest_over_smallest"], ".5g") for name in ("four_point", "double_row"))
    label, text = answer.energy_line(data["energy"])
    ring = "free to tilt" if data["tilt"] else "held upright"
    return [
        ("torque", f"largest over smallest: four-point {four}, double row {double}"),
        (label, f"{text}, mean over the angles"),
        ("solver", f"loads out of balance by {data['solver']['load_imbalance_N']:.1e} N"),
        ("law", f"coulomb, Hertz constants {data['hertz']}, inner ring {ring}"),
    ]


BEARING_COLUMNS = (
    ("angle", "load angle deg", ".4g"),
    ("four", "four-point N mm", ".5g"),
    ("double", "double row N mm", ".5g"),
    ("over", "four-point over double row", ".4g"),
    ("beyond", "balls of the four-point beyond two contacts", "d"),
    ("converged", "converged", "s"),
)
