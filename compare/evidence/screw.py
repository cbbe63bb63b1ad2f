"""Lin 3.4 and 4.3: our values of every printed number, and the findings; each solution is made once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import degrees, radians
from typing import Literal

import numpy as np

from compare.measure import error_percent
from compare.models.study import Study
from compare.printed.findings import Finding, collect, entry
from compare.printed.printed_data import load_table
from lowfi.friction.bearing.pairs import TorqueCurve, double_row, four_point, torque_curve
from lowfi.friction.contact.ellipse import Array
from lowfi.friction.screw.errors import Onset, contact_onset
from lowfi.friction.screw.motion import Coupling
from lowfi.friction.screw.pair import INFERRED_OVERSIZE, PairResult, implied_load, inferred, plain, solve_pair, table_3_6
from lowfi.friction.screw.run import RunResult, lin_3_4_4, resolved, simulate, summarise
from lowfi.friction.screw.steps import StepError

TABLES = ("lin-3.6", "lin-3.7", "lin-3.4.4", "lin-4.2", "lin-4.3")
#: Deviations theta [deg] of the cases of Table 3.7, and amplitudes [deg] of the runs, which 3.4.4 does not print.
THETA = {"a": 2.0, "b": 3.0}
AMPLITUDES = (2.0, 3.0)
#: Angles [rad] of the load in 4.3.1, and ends of the range [deg] that the ratio of torques is taken over.
ANGLES, ENDS = np.radians(np.arange(0.0, 30.1, 2.0)), (10.0, 18.0, 30.0)
#: Error of the steps of a run that is small enough, as a part of its mean torque.
STEP_GOAL = 0.003
#: Steps and time [s] of the runs in the sensitivity table: one turn of the nut, 7.2 degrees a step.
SHORT = {"steps": 50, "duration": 1.0}
#: Scenes of 4.3.2, and velocities of unloaded balls over the nominal one.
SCREWS = {"pitch": "lin-pitch-4p1", "roundness": "lin-roundness-4p1", "none": "lin-nominal-4p1"}
IDLE = (0.0, 0.5, 0.9, 1.0)


@dataclass(frozen=True)
class Ours:
    """Our values of a printed entry in its unit: plain reading, inferred reading; whether a claim holds; evidence."""

    value: float | None = None
    inferred: float | None = None
    holds: bool | None = None
    evidence: str = ""


# --- solutions, each made once


@cache
def pair(case: str, reading: Literal["plain", "inferred"]) -> PairResult:
    """A case of Table 3.7 in a reading."""
    make = plain if reading == "plain" else inferred
    return solve_pair(make(radians(THETA[case])))


@cache
def run(amplitude: float, oversize: float = INFERRED_OVERSIZE, coupling: Coupling = "none") -> RunResult:
    """The whole screw of 3.4.4; amplitude [deg] of theta, oversize [m]. Its steps are chosen by their error (``stepped``)
    unless friction moves the balls: then they are the source's 200."""
    if coupling == "none" and oversize == INFERRED_OVERSIZE:
        return stepped(amplitude)[0]
    return as_stepped(amplitude, oversize, coupling)


@cache
def stepped(amplitude: float) -> tuple[RunResult, StepError | None]:
    """The run with as many steps as keep their error below ``STEP_GOAL``, and that error."""
    return resolved(lin_3_4_4(amplitude=radians(amplitude)), STEP_GOAL)


@cache
def as_stepped(amplitude: float, oversize: float = INFERRED_OVERSIZE, coupling: Coupling = "none") -> RunResult:
    """The run over the source's 200 steps."""
    return simulate(lin_3_4_4(amplitude=radians(amplitude), oversize=oversize, coupling=coupling))


@cache
def curve(name: str, tilt: bool) -> TorqueCurve:
    """Torque against load angle of a bearing of Table 4.2, "4P" or "DR"."""
    return torque_curve(four_point(tilt=tilt) if name == "4P" else double_row(tilt=tilt), ANGLES)


def cut(found: TorqueCurve, end: float) -> float:
    """Largest over smallest torque up to a load angle [deg]."""
    torque = found.torque[found.angle <= radians(end) * (1.0 + 1e-12)]
    return float(torque.max() / torque.min())


def increase(r: PairResult) -> float:
    """Increase of all losses by contact [%]."""
    return float(error_percent(r.touching.motion.loss, r.free.motion.loss))


def onset(study: Study, errors: str, idle: float) -> Onset:
    """Onset of ball-to-ball contact with errors of a kind on the screw of Table 4.1."""
    name = SCREWS[errors]
    return contact_onset(study.scene(name), study.solve(name), idle=idle)


# --- values of the printed entries


def table_3_6_values() -> dict[str, Ours]:
    """Table 3.6: inputs."""
    g = table_3_6()
    values = {
        "R_B": 1e3 * g.ball_radius,
        "conformity": 0.5 * g.groove_radius / g.ball_radius,
        "R_P": 1e3 * g.pitch_radius,
        "lead": 1e3 * g.lead,
        "beta": degrees(g.contact_angle),
        "omega_N": g.speed / np.pi,
        "mu": g.mu,
        "nu": g.poisson,
        "force": plain(0.0).force[0],
    }
    return {key: Ours(float(v)) for key, v in values.items()} | {"E": modulus(g.young)}


def modulus(young: float) -> Ours:
    """Young's modulus in the unit printed."""
    return Ours(1e-6 * young, evidence=f"taken as {1e-9 * young:g} kN/mm²; shown in the unit printed")


def table_3_7_values() -> dict[str, Ours]:
    """Table 3.7 and the text around it: plain reading, inferred reading."""
    printed = {row.key: row.value or 0.0 for row in load_table("lin-3.7")}
    out = {}
    for case in THETA:
        two = pair(case, "plain"), pair(case, "inferred")
        force, more = printed[f"force_{case}"], printed[f"increase_{case}"]
        implied = implied_load(inferred(radians(THETA[case])), force, 1e-2 * more)
        off = [float(error_percent(r.force, force)) for r in two]
        out[f"force_{case}"] = Ours(
            two[0].force,
            two[1].force,
            evidence=f"the text as it stands does not give it ({off[0]:+.0f} %): printed force and increase imply "
            f"{implied:.0f} N of contact load a ball, the plain reading has {two[0].load.mean():.0f} N, the inferred "
            f"one {two[1].load.mean():.0f} N ({off[1]:+.1f} %)",
        )
        off = [float(error_percent(increase(r), more)) for r in two]
        out[f"increase_{case}"] = Ours(
            increase(two[0]), increase(two[1]), evidence=f"plain {off[0]:+.0f} %, inferred {off[1]:+.1f} % off"
        )
        ansys = printed[f"ansys_{case}"]
        out[f"difference_{case}"] = Ours(float(error_percent(force, ansys)), evidence="from the printed forces alone")
        out[f"ansys_{case}"] = Ours(evidence="another program; this project has no 3D model of the pair")
        out[f"time_{case}"] = Ours(evidence="another machine and language; our time is in the table of run times")
    return out


def settled(r: RunResult) -> Array:
    """Torque of the grooves [N m] after the first step, whose loads know of no friction yet."""
    return r.groove_torque[1:]


def variation(r: RunResult) -> float:
    """Largest less smallest torque of the grooves over its mean, from the second step on."""
    torque = settled(r)
    return float(np.ptp(torque) / torque.mean())


def engages_again(r: RunResult) -> bool:
    """Whether contact begins, ends and begins again."""
    touch = np.asarray(np.any(r.contact, axis=1), dtype=bool).reshape(-1)
    changes = touch[np.flatnonzero(np.diff(touch.astype(int)))[:3] + 1]
    return not bool(touch[0]) and changes.tolist() == [True, False, True]


def steps_in_words(amplitude: float) -> str:
    """How many steps the run takes, their error, and what the source's own number of steps would give."""
    (found, error), base = stepped(amplitude), as_stepped(amplitude)
    size = "unknown" if error is None else f"{100.0 * error.torque:.2g} %"
    few = 100.0 * summarise(base).largest
    return (
        f"in {found.run.steps} steps, whose error is {size} of the mean torque; the source's {base.run.steps} steps give "
        f"{few:.1f} %"
    )


def table_3_4_4_values() -> dict[str, Ours]:
    """3.4.4: inputs, the numbers with theta of 3 degrees and beside them with 2, and the claims."""
    base, found = lin_3_4_4(), {a: summarise(run(a)) for a in AMPLITUDES}
    low, high = (found[a] for a in AMPLITUDES)
    inputs = {
        "balls": base.count,
        "turns": base.turns,
        "force": base.force[0],
        "duration": base.duration,
        "steps": base.steps,
        "occupation": 100.0 * base.occupation,
    }
    out = {key: Ours(float(v)) for key, v in inputs.items()}
    assumed = f"assumed: theta of 3 deg (with 2 deg {{}}), balls {1e6 * INFERRED_OVERSIZE:g} µm oversize"
    earlier = "; earlier than printed, see table friction-run-sensitivity"
    both = 100.0 * low.largest, 100.0 * high.largest
    between = f"{assumed.format(f'{both[0]:.1f} %')}: the printed number lies between; the source's rule of contact"
    out["largest"] = Ours(
        both[1],
        evidence=f"{between}, which lets balls overlap, gives less (table friction-run-sensitivity); {steps_in_words(3.0)}",
    )
    out["largest_at"] = Ours(high.at, evidence=assumed.format(f"{low.at:.0f}°") + earlier)
    out["none_at"] = Ours(high.none_at, evidence=assumed.format(f"{low.none_at:.0f}°") + earlier)
    out["groups"] = Ours(
        holds=low.groups == high.groups == 4, evidence=f"{low.groups} groups with 2 deg, {high.groups} with 3 deg"
    )
    vary = [low.groove_variation, high.groove_variation]
    loose = run(3.0, 0.0, "ball and screw")
    out["groove_steady"] = Ours(
        holds=max(vary) < 0.03,
        evidence=f"largest less smallest over mean: {vary[0]:.1%} with 2 deg, {vary[1]:.1%} with 3 deg; without "
        f"oversize, loads coupled to friction, {variation(loose):.1%} from the second step on and "
        f"{summarise(loose).groove_variation:.0%} with the first, whose loads know of no friction yet: mostly the "
        "start, not third contacts that come and go",
    )
    again = [engages_again(run(a)) for a in AMPLITUDES]
    out["none_then_again"] = Ours(holds=all(again), evidence="with 2 and with 3 deg")
    return out


def table_4_2_values() -> dict[str, Ours]:
    """Table 4.2: inputs; dimensions that enter no model here stay open."""
    four, double = four_point(), double_row()
    g = four.groove
    values = {
        "pitch_diameter": 2e3 * g.pitch_radius,
        "beta": degrees(g.contact_angle),
        "nu": g.poisson,
        "thickness_dr": 2e3 * (double.rows[1].place - double.rows[0].place),
        "force": four.force,
        "speed": g.screw_speed / (2.0 * np.pi),
    }
    for key, case in (("4p", four), ("dr", double)):
        values |= {
            f"ball_{key}": 1e3 * case.groove.ball_radius,
            f"groove_{key}": 1e3 * case.groove.groove_radius,
            f"balls_{key}": case.count,
        }
    out = {key: Ours(float(v)) for key, v in values.items()} | {"E": modulus(g.young)}
    out["thickness_dr"] = replace(out["thickness_dr"], evidence="only twice the distance of the rows, an assumption")
    for key in ("outer_diameter", "inner_diameter", "thickness_4p"):
        out[key] = Ours(evidence="enters no model here: nothing to compare")
    return out


def table_4_3_values(study: Study) -> dict[str, Ours]:
    """4.3.1 and the conclusion of 4.3.2 carried through to ball-to-ball contact."""
    four, double = curve("4P", True), curve("DR", True)
    ratios = cut(four, 18.0), cut(double, 18.0), cut(curve("DR", False), 18.0)
    at_18 = int(four.four[np.searchsorted(four.angle, radians(18.0) * (1.0 - 1e-12))])
    still = cut(curve("4P", False), 18.0)
    first = {(e, i): degrees(onset(study, e, i).first) for e in ("pitch", "roundness") for i in (0.0, 0.9)}
    lost = {e: int((onset(study, e, 0.0).loaded == 0.0).sum()) for e in ("pitch", "roundness")}
    return {
        "ratio_4p": Ours(
            ratios[0], evidence=f"load angles of 0 to 18 deg, inner ring free to tilt; {still:.2f} where it cannot tilt"
        ),
        "four_worse": Ours(holds=ratios[0] > 3.0 * max(ratios[1:]), evidence=f"{ratios[0]:.2f} against {ratios[1]:.2f}"),
        "dr_consistent": Ours(
            holds=bool(np.all(double.four == 0)) and ratios[1] < 1.28,
            evidence=f"never more than two contacts a ball; ratio {ratios[1]:.2f} with tilt, {ratios[2]:.2f} without",
        ),
        "transition": Ours(
            holds=four.four[0] == 0 and at_18 > 0,
            evidence=f"{int(four.four[0])} balls beyond two contacts at 0 deg, {at_18} of 9 at 18 deg",
        ),
        "roundness_quicker": Ours(
            holds=all(first["roundness", i] < first["pitch", i] for i in (0.0, 0.9)),
            evidence=f"first meeting within {first['roundness', 0.0]:.1f} deg of the nut if lost balls stand, "
            f"{first['roundness', 0.9]:.0f} deg at 0.9 of the nominal velocity; with pitch error "
            f"{first['pitch', 0.0]:.0f} deg; {lost['roundness']} balls lost against {lost['pitch']}",
        ),
    }


def ours(study: Study) -> dict[str, dict[str, Ours]]:
    """Our values of all tables."""
    made = (table_3_6_values(), table_3_7_values(), table_3_4_4_values(), table_4_2_values(), table_4_3_values(study))
    return dict(zip(TABLES, made, strict=True))


def findings(study: Study) -> list[Finding]:
    """Every printed entry of 3.4 and 4.3.1; Table 3.7 is held against the plain reading, the inferred one beside it."""
    return findings_of(ours(study))


def findings_of(values: dict[str, dict[str, Ours]]) -> list[Finding]:
    """Findings of printed entries by table and key."""
    out = []
    for table, own in values.items():
        made = {key: Finding(entry(table, key), v.value, None, v.holds, _evidence(v)) for key, v in own.items()}
        out += collect(table, made)
    return out


def _evidence(v: Ours) -> str:
    """Evidence with both readings named where there are two."""
    if v.inferred is None or v.value is None:
        return v.evidence
    return f"plain reading {v.value:.4g}, inferred reading {v.inferred:.4g}; {v.evidence}"
