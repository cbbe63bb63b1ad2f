"""Solves friction scenes of a ball screw: two balls, and a whole screw in time."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np

from rollbench.compare.quantities import number
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.compare.studies.friction import answer
from rollbench.compare.studies.friction.run import judged, run_data, run_lines, stepped
from rollbench.compare.text.printing import Column, cell
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.pair import PairResult, solve_pair
from rollbench.lowfi.friction.screw.run import summarise
from rollbench.lowfi.friction.screw.travel import History
from rollbench.lowfi.statics.validity import size_warnings
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Motion

#: Overlap of neighbours [rad] that is round-off.
TOUCHING = 1e-9


def sliding(groove: ScrewGroove, force: Array) -> float:
    """Dissipation [W] if all contacts slid at the full speed of the bodies; inf at rest: all of it is round-off."""
    if groove.speed == 0.0:
        return np.inf
    return groove.mu * float(force.sum()) * abs(groove.speed) * groove.radius


def screw_warnings(groove: ScrewGroove, force: Array) -> list[Warned]:
    """Warn of contacts that are large against the ball; forces (..., 4) [N]."""
    return size_warnings((groove.constants.C_a * np.cbrt(force)).ravel(), groove.ball_radius)


# --- two balls


def pair_rows(r: PairResult) -> list[dict[str, Any]]:
    """One row per ball and state."""
    return [
        {"index": k + 1, "state": state}
        | answer.load_row(SIDES, chain.load.force[k], chain.load.angle[k])
        | answer.motion_row(chain.motion.q[k])
        | {"groove_loss_mW": number(1e3 * chain.motion.groove_loss[k].sum())}
        for state, chain in (("apart", r.free), ("touching", r.touching))
        for k in range(2)
    ]


def pair_status(r: PairResult) -> str:
    """How a pair ended, in words."""
    if r.converged:
        return "converged"
    if all(c.load.converged and c.motion.converged for c in (r.free, r.touching)):
        return "loads and friction do not agree"
    return "no balance of the loads or of friction found"


def solve_screw_pair(scene: ScrewPairScene) -> answer.FrictionAnswer:
    """Forces, losses and what contact adds to friction for two balls of a ball screw."""
    pair = scene.pair
    r = solve_pair(pair)
    m, apart, rows, chains = r.touching.motion, r.free.motion.loss, pair_rows(r), (r.free, r.touching)
    bound, ball_loss = sliding(pair.groove, r.touching.load.force), float(m.ball_loss.sum())
    between = {"balls": "1-2", "gap_um": 0.0, "force_N": number(r.force), "loss_mW": number(1e3 * ball_loss)}
    solver = {
        "load_imbalance_N": number(max(c.load.left for c in chains)),
        "friction_imbalance_N": number(max(c.motion.left for c in chains)),
        "feedback_change_N": number(max(c.change for c in chains)) if pair.coupling != "none" else 0.0,
        "rounds": max(c.rounds for c in chains),
    }
    data = answer.head(scene, pair_status(r), r.converged, pair.coupling) | {
        "law": "coulomb",
        "hertz": answer.hertz_word(pair.groove.hertz),
        "coupling": pair.coupling,
        "coupled": pair.coupling != "none",
        "deviation_deg": [number(degrees(t)) for t in pair.theta],
        "oversize_um": number(1e6 * pair.oversize),
        "balls": rows,
        "pairs": [between | {"closing_apart_rad_s": number(r.closing)}],
        "load_sum_N": [number(f) for f in r.load],
        **answer.by_contact(m.input_power, m.loss, apart, ball_loss, bound),
        "solver": solver,
        "warnings": screw_warnings(pair.groove, r.touching.load.force),
    }
    return answer.FrictionAnswer(
        data, [("per ball", PAIR_COLUMNS, [answer.flat_ball(SIDES, row) for row in rows])], pair_lines(data), r.converged
    )


def pair_lines(data: dict[str, Any]) -> list[answer.Line]:
    """The results of two balls in a few lines."""
    (pair,), rise, solver = data["pairs"], data["friction_increase_percent"], data["solver"]
    return [
        (
            "force",
            f"{pair['force_N']:.6g} N from ball to ball, loss there {data['ball_to_ball_loss_W']:.6g} W"
            + ("" if rise is None else f"; contact changes all losses by {rise:+.4g} %"),
        ),
        ("closing", f"when apart the balls close in at {pair['closing_apart_rad_s']:.6g} rad/s of azimuth"),
        answer.energy_line(data["energy"]),
        answer.solver_line(solver, f", {solver['rounds']} rounds"),
        law_line(data),
    ]


def law_line(data: dict[str, Any]) -> answer.Line:
    """The law of friction, the contacts' constants and what friction moves."""
    return "law", f"coulomb, Hertz constants {data['hertz']}, coupling of friction to loads: {data['coupling']}"


PAIR_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    ("state", "state", "s"),
    *((f"{s} N", f"{s} N", ".3f") for s in SIDES),
    ("orbit_rad_s", "orbit rad/s", ".6f"),
    *((f"omega {n}", f"omega_{n} rad/s", ".4f") for n in "xyz"),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)


# --- a whole screw


def order_kept(h: History) -> bool:
    """Whether no ball ever passes or overlaps the next one, the last and the first included."""
    ahead = np.diff(np.column_stack([h.ends, h.ends[:, 0] + h.setting.ring]), axis=1)
    return bool(ahead.min() >= h.setting.groove.pair.spacing - TOUCHING)


def run_summary(h: History) -> dict[str, Any]:
    """What happens in the run: nut angles [deg], torques [N mm], gaps [um], shares [%] of the grooves' torque."""
    s, touch, nut = summarise(h), np.any(h.contact, axis=1), np.degrees(h.nut_angle)
    met = bool(touch.any())
    torques = {
        "mean_torque_Nmm": h.torque,
        "mean_groove_torque_Nmm": h.groove_torque,
        "mean_ball_torque_Nmm": h.ball_torque + h.closing_torque,
        "mean_closing_torque_Nmm": h.closing_torque,
    }
    return {
        "largest_ball_to_groove_percent": number(100.0 * s.largest),
        "largest_at_deg": number(s.at) if met else None,
        "contact_begins_deg": number(nut[np.argmax(touch)]) if met else None,
        "contact_ends_deg": number(s.none_at) if met else None,
        "contact_ends_within_deg": number(degrees(abs(h.setting.groove.speed) * h.span / h.steps)) if met else None,
        "largest_groups": s.groups,
        **{name: number(1e3 * h.mean(values)) for name, values in torques.items()},
        "groove_variation_percent": number(100.0 * s.groove_variation),
        "largest_ball_force_N": number(h.ball_force.max()),
        "order_kept": order_kept(h),
        "smallest_gap_um": number(1e6 * h.setting.groove.radius * h.gap.min()),
        "occupation_percent": number(100.0 * h.setting.occupation),
    }


def run_series(h: History) -> dict[str, list[Any]]:
    """Time series, one entry per piece of a step; time and nut angle in its middle."""
    values = {
        "time_s": h.time,
        "nut_angle_deg": np.degrees(h.nut_angle),
        "groove_torque_Nmm": 1e3 * h.groove_torque,
        "ball_torque_Nmm": 1e3 * (h.ball_torque + h.closing_torque),
        "ball_to_groove_percent": 100.0 * h.ratio,
        "largest_ball_force_N": h.ball_force.max(axis=1),
        "smallest_gap_um": 1e6 * h.setting.groove.radius * h.gap.min(axis=1),
        "balance_percent": 100.0 * h.imbalance,
    }
    out: dict[str, list[Any]] = {name: [number(v) for v in row] for name, row in values.items()}
    out |= {"contacts": h.contact.sum(axis=1).tolist(), "groups": h.groups.tolist()}
    return out | {"converged": h.converged.tolist()}


def solve_run(scene: ScrewRunScene) -> answer.FrictionAnswer:
    """Contacts, torques and energy of a whole screw in time."""
    run, time = scene.run, scene.time
    in_time = judged(*stepped(run, Motion(run.groove.speed), time, scene.name), time)
    h, speed = in_time.history, abs(run.groove.speed)
    bound = sliding(run.groove, h.load) / h.time.size
    loss = h.torque * speed
    spent = answer.energy(h.mean(loss * (1.0 + h.imbalance)), h.mean(loss), bound)
    known = spent["balance_percent"] is not None
    largest = answer.without_round_off(float(np.abs(h.imbalance).max()), 1.0)
    spent["largest_step_balance_percent"] = number(100.0 * largest) if known else None
    summary, failed = run_summary(h), int(np.sum(~h.converged))
    found = run_data(in_time)
    data = answer.head(scene, in_time.status, in_time.converged, run.coupling) | {
        "law": "coulomb",
        "hertz": answer.hertz_word(run.groove.hertz),
        "coupling": run.coupling,
        "coupled": run.coupling != "none",
        "ball_count": run.count,
        "steps": h.steps,
        "duration_s": number(run.duration),
        "amplitude_deg": number(degrees(run.amplitude)),
        "oversize_um": number(1e6 * run.oversize),
        "summary": summary,
        "energy": spent,
        "series": run_series(h),
        "solver": {"failed_steps": failed, "feedback_change_N": number(h.change.max()) if run.coupling != "none" else 0.0},
        "step_error": found["step_error"],
        "run": found,
        "warnings": screw_warnings(run.groove, h.load),
    }
    label, text = answer.energy_line(spent)
    lines = [
        *run_lines(in_time),
        ("balls", f"{run.count} over {run.duration:.6g} s"),
        (label, f"{text}, at most {largest:.1e} of the loss out of balance at an instant" if largest else text),
        ("solver", f"{failed} of {h.time.size} instants failed"),
        law_line(data),
    ]
    shown = [{"quantity": label, "value": cell(summary[name], form)} for name, label, form in RUN_LINES]
    return answer.FrictionAnswer(data, [("summary", RUN_COLUMNS, shown)], lines, in_time.converged)


RUN_COLUMNS = (("quantity", "quantity", "s"), ("value", "value", "s"))
RUN_LINES = (
    ("largest_ball_to_groove_percent", "largest torque by ball-to-ball contact over the grooves' %", ".4g"),
    ("largest_at_deg", "nut angle of it deg", ".4g"),
    ("contact_begins_deg", "nut angle where contact begins deg", ".4g"),
    ("contact_ends_deg", "nut angle of the first instant without contact after the largest deg", ".4g"),
    ("contact_ends_within_deg", "known to one step of deg", ".4g"),
    ("largest_groups", "groups of touching balls at most", "d"),
    ("mean_torque_Nmm", "mean torque N mm", ".5g"),
    ("mean_groove_torque_Nmm", "of ball to groove N mm", ".5g"),
    ("mean_ball_torque_Nmm", "of ball to ball N mm", ".5g"),
    ("mean_closing_torque_Nmm", "of which by gaps that close N mm", ".3g"),
    ("groove_variation_percent", "variation of the grooves' torque %", ".4g"),
    ("largest_ball_force_N", "largest ball-to-ball force N", ".5g"),
    ("order_kept", "order of balls kept", "s"),
    ("smallest_gap_um", "smallest gap um", ".3g"),
    ("occupation_percent", "loaded track filled by all balls %", ".4g"),
)
