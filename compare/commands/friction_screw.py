"""Solves friction scenes of a ball screw (two balls, a whole screw in time) and of bearings in pairs."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np

from compare.commands.friction_kinds import NOTHING, Answer, balance, balance_line, cell, head, size_warnings
from compare.commands.friction_run import error_data
from compare.commands.solve_output import number
from compare.measure import error_percent
from compare.scenes.friction_scene import FrictionScene
from compare.scenes.friction_screw_scene import BearingPairScene, ScrewPairScene, ScrewRunScene
from lowfi.friction.bearing.pairs import BearingCase, BearingState, solve_bearing
from lowfi.friction.contact.ellipse import Array
from lowfi.friction.screw.groove import ScrewGroove
from lowfi.friction.screw.pair import PairResult, solve_pair
from lowfi.friction.screw.run import RunResult, checked, groups, summarise
from lowfi.friction.screw.steps import StepError
from meshes.parts import SIDES

#: Overlap of neighbours [rad] that is round-off.
TOUCHING = 1e-9


#: Error of the steps of a run, as a part of its mean torque, beyond which it is warned of.
STEP_GOAL = 0.01


def solve(scene: FrictionScene) -> Answer:
    """Solve a scene of a ball screw or of bearings in pairs."""
    if isinstance(scene, ScrewRunScene):
        return solve_run(scene)
    if isinstance(scene, BearingPairScene):
        return solve_bearings(scene)
    assert isinstance(scene, ScrewPairScene)
    return solve_screw_pair(scene)


def sliding(groove: ScrewGroove, force: Array) -> float:
    """Dissipation [W] if all contacts slid at the full speed of the bodies; inf at rest: all of it is round-off."""
    if groove.speed == 0.0:
        return np.inf
    return groove.mu * float(force.sum()) * abs(groove.speed) * groove.radius


def screw_warnings(groove: ScrewGroove, force: Array) -> list[str]:
    """Warn of contacts that are large against the ball; forces (..., 4) [N]."""
    return size_warnings((groove.constants.C_a * np.cbrt(force)).ravel(), groove.ball_radius)


# --- two balls


def pair_rows(r: PairResult) -> list[dict[str, Any]]:
    """One row per ball and state."""
    rows = []
    for state, chain in (("apart", r.free), ("touching", r.touching)):
        for k in range(2):
            q, loss = chain.motion.q[k], chain.motion.groove_loss[k]
            rows.append(
                {
                    "ball": k + 1,
                    "state": state,
                    "load_N": {s: number(f) for s, f in zip(SIDES, chain.load.force[k], strict=True)},
                    "angle_deg": {s: number(degrees(a)) for s, a in zip(SIDES, chain.load.angle[k], strict=True)},
                    "orbit_rad_s": number(q[0]),
                    "omega_x_rad_s": number(q[1]),
                    "omega_y_rad_s": number(q[2]),
                    "omega_z_rad_s": number(q[3]),
                    "groove_loss_mW": number(1e3 * loss.sum()),
                }
            )
    return rows


def pair_status(r: PairResult) -> str:
    """How a pair ended, in words."""
    if r.converged:
        return "converged"
    if all(c.load.converged and c.motion.converged for c in (r.free, r.touching)):
        return "loads and friction do not agree"
    return "no balance of the loads or of friction found"


def solve_screw_pair(scene: ScrewPairScene) -> Answer:
    """Forces, losses and what contact adds to friction for two balls of a ball screw."""
    pair = scene.pair
    r = solve_pair(pair)
    m, rows = r.touching.motion, pair_rows(r)
    bound = sliding(pair.groove, r.touching.load.force)
    energy = balance(m.input_power, m.loss, bound)
    rubs = r.free.motion.loss > NOTHING * bound
    rise = number(float(error_percent(m.loss, r.free.motion.loss))) if rubs else None
    chains = (r.free, r.touching)
    data = head(scene, "screw pair", pair_status(r), r.converged) | {
        "law": "coulomb",
        "hertz": pair.groove.hertz,
        "coupling": pair.coupling,
        "coupled": pair.coupling != "none",
        "deviation_deg": [number(degrees(t)) for t in pair.theta],
        "oversize_um": number(1e6 * pair.oversize),
        "balls": rows,
        "ball_force_N": number(r.force),
        "contact_load_N": [number(f) for f in r.load],
        "closing_rad_s": number(r.closing),
        "loss_apart_W": number(r.free.motion.loss),
        "friction_increase_percent": rise,
        "ball_to_ball_percent": number(100.0 * r.rubbing_ratio) if rubs else None,
        "ball_to_ball_loss_W": number(m.ball_loss.sum()),
        "energy": energy,
        "solver": {
            "load_imbalance_N": number(max(c.load.left for c in chains)),
            "friction_imbalance_N": number(max(c.motion.left for c in chains)),
            "feedback_change_N": number(max(c.change for c in chains)) if pair.coupling != "none" else 0.0,
            "rounds": max(c.rounds for c in chains),
        },
        "assumed": list(scene.assumed),
        "warnings": screw_warnings(pair.groove, r.touching.load.force),
    }
    solver = data["solver"]
    lines = [
        f"ball-to-ball force {r.force:.6g} N, loss there {cell(data['ball_to_ball_loss_W'], '.6g')} W"
        + ("" if rise is None else f"; contact changes all losses by {rise:+.4g} %"),
        f"when apart the balls close in at {r.closing:.6g} rad/s of azimuth",
        balance_line(energy),
        f"solver: loads out of balance by {solver['load_imbalance_N']:.1e} N, friction by "
        f"{solver['friction_imbalance_N']:.1e} N, {solver['rounds']} rounds",
        f"law coulomb, Hertz constants {pair.groove.hertz}, coupling of friction to loads: {pair.coupling}",
    ]
    flat = [row | {f"{s} N": row["load_N"][s] for s in SIDES} for row in rows]
    return Answer(data, [("per ball", PAIR_COLUMNS, flat)], lines, r.converged)


PAIR_COLUMNS = (
    ("ball", "ball", "s"),
    ("state", "state", "s"),
    *((f"{s} N", f"{s} N", ".3f") for s in SIDES),
    ("orbit_rad_s", "orbit rad/s", ".6f"),
    ("omega_x_rad_s", "omega_x rad/s", ".4f"),
    ("omega_y_rad_s", "omega_y rad/s", ".4f"),
    ("omega_z_rad_s", "omega_z rad/s", ".4f"),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)


# --- a whole screw


def order_kept(r: RunResult) -> bool:
    """Whether no ball ever passes or overlaps the next one, the last and the first included."""
    ahead = np.diff(np.column_stack([r.azimuth, r.azimuth[:, 0] + r.run.ring]), axis=1)
    return bool(min(ahead.min(), r.spacing.min()) >= r.run.groove.pair.spacing - TOUCHING)


def run_summary(r: RunResult) -> dict[str, Any]:
    """What happens in the run: nut angles [deg], torques [N mm], gaps [um], shares [%] of the grooves' torque."""
    s, touch, nut = summarise(r), np.any(r.contact, axis=1), np.degrees(r.nut_angle)
    met = bool(touch.any())
    closing, radius = r.closing_torque, r.run.groove.radius
    return {
        "largest_ball_to_groove_percent": number(100.0 * s.largest),
        "largest_at_deg": number(s.at) if met else None,
        "contact_begins_deg": number(nut[np.argmax(touch)]) if met else None,
        "contact_ends_deg": number(s.none_at) if met else None,
        "largest_groups": s.groups,
        "mean_torque_Nmm": number(1e3 * r.torque.mean()),
        "mean_groove_torque_Nmm": number(1e3 * r.groove_torque.mean()),
        "mean_ball_torque_Nmm": number(1e3 * (r.ball_torque + closing).mean()),
        "mean_closing_torque_Nmm": number(1e3 * closing.mean()),
        "groove_variation_percent": number(100.0 * s.groove_variation),
        "largest_ball_force_N": number(r.ball_force.max()),
        "order_kept": order_kept(r),
        "smallest_gap_um": number(1e6 * radius * r.gap.min()),
        "occupation_percent": number(100.0 * r.run.occupation),
    }


def run_series(r: RunResult) -> dict[str, list[Any]]:
    """Time series, one entry per step; time and nut angle at its start."""
    speed, radius = r.run.groove.speed, r.run.groove.radius
    values = {
        "time_s": r.nut_angle / speed,
        "nut_angle_deg": np.degrees(r.nut_angle),
        "groove_torque_Nmm": 1e3 * r.groove_torque,
        "ball_torque_Nmm": 1e3 * (r.ball_torque + r.closing_torque),
        "ball_to_groove_percent": 100.0 * r.ratio,
        "largest_ball_force_N": r.ball_force.max(axis=1),
        "smallest_gap_um": 1e6 * radius * r.gap.min(axis=1),
        "balance_percent": 100.0 * r.imbalance,
    }
    counts = {"contacts": r.contact.sum(axis=1), "groups": groups(r.contact)}
    out: dict[str, list[Any]] = {name: [number(v) for v in row] for name, row in values.items()}
    out |= {name: [int(v) for v in row] for name, row in counts.items()}
    return out | {"converged": [bool(v) for v in r.converged]}


def step_warnings(error: StepError | None) -> list[str]:
    """What to say of a run whose steps are too long, or whose error is not known."""
    if error is None:
        return ["the error of the steps is not known: take an even number of steps"]
    if error.small(STEP_GOAL):
        return []
    return [f"the error of the steps is some {100.0 * error.torque:.2g} % of the mean torque: take more steps"]


def solve_run(scene: ScrewRunScene) -> Answer:
    """Contacts, torques and energy of a whole screw in time."""
    run = scene.run
    r, error = checked(run)
    failed, speed = int(np.sum(~r.converged)), abs(run.groove.speed)
    status = "converged" if failed == 0 else f"{failed} of {run.steps} steps did not converge"
    loss = r.torque * speed
    bound = sliding(run.groove, r.load) / run.steps
    energy = balance(float((loss * (1.0 + r.imbalance)).mean()), float(loss.mean()), bound)
    energy["largest_step_balance_percent"] = number(100.0 * np.abs(r.imbalance).max())
    summary = run_summary(r)
    data = head(scene, "screw run", status, failed == 0) | {
        "law": "coulomb",
        "hertz": run.groove.hertz,
        "coupling": run.coupling,
        "coupled": run.coupling != "none",
        "balls": run.count,
        "steps": run.steps,
        "duration_s": number(run.duration),
        "amplitude_deg": number(degrees(run.amplitude)),
        "oversize_um": number(1e6 * run.oversize),
        "summary": summary,
        "energy": energy,
        "series": run_series(r),
        "solver": {"failed_steps": failed, "feedback_change_N": number(r.change.max()) if run.coupling != "none" else 0.0},
        "assumed": list(scene.assumed),
        "step_error": None if error is None else error_data(error, STEP_GOAL),
        "warnings": [*screw_warnings(run.groove, r.load), *step_warnings(error)],
    }
    lines = [
        f"{run.count} balls, {run.steps} steps over {run.duration:.6g} s, nut turns by "
        f"{degrees(speed * run.duration):.6g} deg on the screw",
        balance_line(energy) + f", at most {cell(energy['largest_step_balance_percent'], '.1e')} % in a step",
        f"solver: {failed} of {run.steps} steps failed",
        f"law coulomb, Hertz constants {run.groove.hertz}, coupling of friction to loads: {run.coupling}",
    ]
    shown = [{"quantity": label, "value": cell(summary[name], form)} for name, label, form in RUN_LINES]
    return Answer(data, [("summary", RUN_COLUMNS, shown)], lines, failed == 0)


RUN_COLUMNS = (("quantity", "quantity", "s"), ("value", "value", "s"))
RUN_LINES = (
    ("largest_ball_to_groove_percent", "largest torque by ball-to-ball contact over the grooves' %", ".4g"),
    ("largest_at_deg", "nut angle of it deg", ".4g"),
    ("contact_begins_deg", "nut angle where contact begins deg", ".4g"),
    ("contact_ends_deg", "nut angle of the first step without contact after the largest deg", ".4g"),
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


# --- bearings in pairs


def bearing_states(case: BearingCase, angle: Array) -> list[BearingState]:
    """States of a bearing at load angles (n,) [rad], each the start of the next."""
    states: list[BearingState] = []
    for a in angle:
        states.append(solve_bearing(case, float(a), states[-1] if states else None))
    return states


def over(part: float, whole: float) -> float | None:
    """A ratio; None of nothing."""
    return number(part / whole) if whole > 0.0 else None


def bearing_data(states: list[BearingState]) -> dict[str, Any]:
    """A bearing's torques [N mm] over the angles and the largest over the smallest."""
    torque = [1e3 * s.torque for s in states]
    return {
        "torque_Nmm": [number(t) for t in torque],
        "balls_beyond_two_contacts": [int(np.sum(s.points > 2)) for s in states],
        "ratio": over(max(torque), min(torque)),
        "converged": [s.converged for s in states],
    }


def solve_bearings(scene: BearingPairScene) -> Answer:
    """Friction torque of both bearings over the angle of the load; the energy is the mean over all states."""
    cases = scene.four_point, scene.double_row
    both = [bearing_states(case, scene.angle) for case in cases]
    four, double = map(bearing_data, both)
    good = [f and d for f, d in zip(four["converged"], double["converged"], strict=True)]
    status = "converged" if all(good) else f"{good.count(False)} of {len(good)} load angles did not converge"
    ratios = [over(f.torque, d.torque) for f, d in zip(*both, strict=True)]
    states = [s for one in both for s in one]
    bounds = [sliding(c.groove, s.load.force) for c, one in zip(cases, both, strict=True) for s in one]
    power, loss, bound = (
        float(np.mean(v)) for v in ([s.input_power for s in states], [s.loss.sum() for s in states], bounds)
    )
    energy, case, angle = balance(power, loss, bound), scene.four_point, [number(a) for a in np.degrees(scene.angle)]
    large = [
        f"{name}: {w}"
        for name, c, one in zip(("four-point", "double row"), cases, both, strict=True)
        for w in screw_warnings(c.groove, np.stack([s.load.force for s in one]))
    ]
    data = head(scene, "bearing pair", status, all(good)) | {
        "law": "coulomb",
        "hertz": case.groove.hertz,
        "coupled": False,
        "force_N": number(case.force),
        "tilt": case.tilt,
        "angle_deg": angle,
        "four_point": four,
        "double_row": double,
        "four_over_double": ratios,
        "energy": energy,
        "solver": {"load_imbalance_N": number(max(s.load.left for s in states))},
        "assumed": list(scene.assumed),
        "warnings": large,
    }
    rows = [
        dict(zip((name for name, _, _ in BEARING_COLUMNS), row, strict=True))
        for row in zip(
            angle, four["torque_Nmm"], double["torque_Nmm"], ratios, four["balls_beyond_two_contacts"], good, strict=True
        )
    ]
    lines = [
        f"largest over smallest torque: four-point {cell(four['ratio'], '.5g')}, double row {cell(double['ratio'], '.5g')}",
        f"mean {balance_line(energy)}",
        f"solver: loads out of balance by {data['solver']['load_imbalance_N']:.1e} N",
        f"law coulomb, Hertz constants {case.groove.hertz}, inner ring {'free to tilt' if case.tilt else 'held upright'}",
    ]
    return Answer(data, [("over the load's angle", BEARING_COLUMNS, rows)], lines, all(good))


BEARING_COLUMNS = (
    ("angle", "load angle deg", ".4g"),
    ("four", "four-point N mm", ".5g"),
    ("double", "double row N mm", ".5g"),
    ("over", "four-point over double row", ".4g"),
    ("beyond", "balls of the four-point beyond two contacts", "d"),
    ("converged", "converged", "s"),
)
