"""Sections 3.4 and 4.3: evidence of every printed number, each solution made once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import degrees, radians
from typing import Literal

import numpy as np

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import value_of
from rollbench.compare.scenes.catalogue import case as case_of
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairScene
from rollbench.lowfi.friction.bearing.pairs import TorqueCurve, torque_curve
from rollbench.lowfi.friction.screw.pair import PairResult, implied_load, solve_pair
from rollbench.lowfi.friction.screw.run import equal_steps, summarise
from rollbench.lowfi.friction.screw.travel import History, StepError, resolved
from rollbench.lowfi.friction.whole.onset import Onset, contact_onset
from rollbench.meshes.arrays import Array

#: Deviations theta [deg] of the cases of Table 3.7, and amplitudes [deg] of the runs, which 3.4.4 does not print.
THETA = {name: degrees(source_cases.deviation(name)) for name in source_cases.PAIR_SCENES}
AMPLITUDES = tuple(source_cases.RUN_SCENES)
#: Angles [rad] of the load in 4.3.1.
ANGLES = source_cases.bearings().angle
#: Error of the steps of a run that is small enough, as a fraction of its mean torque.
STEP_GOAL = 0.003
#: Scenes of 4.3.2.
SCREWS = {"pitch": "lin-pitch-4p1", "roundness": "lin-roundness-4p1", "none": "lin-nominal-4p1"}


# --- solutions, each made once


@cache
def pair(case: str, reading: Literal["plain", "inferred"]) -> PairResult:
    """A case of Table 3.7 in a reading."""
    return solve_pair(case_of(source_cases.PAIR_SCENES[case] + "-inferred" * (reading == "inferred"), ScrewPairScene).pair)


@cache
def screw_run(amplitude: float) -> History:
    """The whole screw of 3.4.4 in steps chosen by their error (``stepped``); amplitude [deg] of theta."""
    return stepped(amplitude)[0]


@cache
def stepped(amplitude: float) -> tuple[History, StepError | None]:
    """The run with as many steps as keep their error below ``STEP_GOAL``, and that error."""
    run = source_cases.run_of(amplitude)
    return resolved(run, run.duration, None, STEP_GOAL)


@cache
def as_stepped(amplitude: float) -> History:
    """The run over the source's 200 steps, loads and motions at the start of each."""
    return equal_steps(source_cases.run_of(amplitude))


@cache
def loose_run() -> History:
    """The same with 3 degrees, without oversize, friction moving balls and screw."""
    return equal_steps(replace(source_cases.run_of(3.0), oversize=0.0, coupling="ball and screw"))


@cache
def curve(name: str, tilt: bool) -> TorqueCurve:
    """Torque against load angle of a bearing of Table 4.2, "4P" or "DR"."""
    return torque_curve(source_cases.four_point(tilt=tilt) if name == "4P" else source_cases.double_row(tilt=tilt), ANGLES)


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


def given_3_6(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Table 3.6: inputs."""
    g = source_cases.table_3_6()
    values = {
        "R_B": 1e3 * g.ball_radius,
        "conformity": 0.5 * g.groove_radius / g.ball_radius,
        "R_P": 1e3 * g.pitch_radius,
        "lead": 1e3 * g.lead,
        "beta": degrees(g.contact_angle),
        "omega_N": g.speed / np.pi,
        "mu": g.mu,
        "nu": g.poisson,
        "force": source_cases.plain(0.0).force[0],
        "theta_1": degrees(source_cases.plain().theta[0]),
        "theta_2_a": THETA["a"],
        "theta_2_b": THETA["b"],
    }
    sheet.numbers(values)
    _modulus(sheet, g.young)


def _modulus(sheet: Sheet, young: float) -> None:
    """Young's modulus in the unit printed."""
    sheet.number("E", 1e-6 * young, f"taken as {1e-9 * young:g} kN/mm²; shown in the unit printed")


def table_3_7(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Table 3.7 and the text around it: plain reading and inferred reading."""
    for case in THETA:
        _pair_of_3_7(sheet, case)
        force, ansys = (value_of("lin-3.7", f"{what}_{case}") for what in ("force", "ansys"))
        sheet.number(f"difference_{case}", float(error_percent(force, ansys)), "from the printed forces alone")
        sheet.words(f"ansys_{case}", "another program; the 3D model of this project is in table rolling-pairs")
        words = "another machine and language; run times of this project are in table timing-friction"
        sheet.words(f"time_{case}", words)


def _pair_of_3_7(sheet: Sheet, case: str) -> None:
    force, percent = (value_of("lin-3.7", f"{what}_{case}") for what in ("force", "increase"))
    as_text, oversized = pair(case, "plain"), pair(case, "inferred")
    implied = implied_load(source_cases.inferred(radians(THETA[case])), force, 1e-2 * percent)
    off = [float(error_percent(r.force, force)) for r in (as_text, oversized)]
    sheet.number(
        f"force_{case}",
        as_text.force,
        f"{_both(as_text.force, oversized.force)}; the text as it stands does not give it ({off[0]:+.0f} %): printed force "
        f"and increase imply {implied:.0f} N of contact load a ball, the plain reading has {as_text.load.mean():.0f} N, "
        f"the inferred one {oversized.load.mean():.0f} N ({off[1]:+.1f} %)",
        reading=oversized.force,
    )
    values = increase(as_text), increase(oversized)
    off = [float(error_percent(value, percent)) for value in values]
    words = f"{_both(*values)}; plain {off[0]:+.0f} %, inferred {off[1]:+.1f} % off"
    sheet.number(f"increase_{case}", values[0], words, reading=values[1])


def _both(as_text: float, oversized: float) -> str:
    return f"plain reading {as_text:.4g}, inferred reading {oversized:.4g}"


def settled(r: History) -> Array:
    """Torque of the grooves [N m] after the first step, whose loads are computed without friction."""
    return r.groove_torque[1:]


def variation(r: History) -> float:
    """Largest less smallest torque of the grooves over its mean, from the second step on."""
    torque = settled(r)
    return float(np.ptp(torque) / torque.mean())


def engages_again(r: History) -> bool:
    """Whether contact begins, ends and begins again."""
    touch = np.asarray(np.any(r.contact, axis=1), dtype=bool).reshape(-1)
    changes = touch[np.flatnonzero(np.diff(touch.astype(int)))[:3] + 1]
    return not bool(touch[0]) and changes.tolist() == [True, False, True]


def steps_in_words(amplitude: float) -> str:
    """How many steps the run takes, their error, and what the source's own number of steps would give."""
    (found, error), base = stepped(amplitude), as_stepped(amplitude)
    size = "unknown" if error is None else f"{100.0 * error.largest:.2g} %"
    few = 100.0 * summarise(base).largest
    return (
        f"in {found.steps} steps, whose error is {size} of the mean torque; the source's {base.steps} steps give "
        f"{few:.1f} %"
    )


def section_3_4_4(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """3.4.4: inputs, the numbers with theta of 3 degrees (and of 2 in the words), and the claims."""
    base = source_cases.lin_3_4_4()
    inputs = {
        "balls": base.count,
        "turns": base.turns,
        "force": base.force[0],
        "duration": base.duration,
        "steps": base.steps,
        "occupation": 100.0 * base.occupation,
    }
    sheet.numbers(inputs)
    _numbers_of_run(sheet)
    _claims_of_run(sheet)


def _numbers_of_run(sheet: Sheet) -> None:
    low, high = (summarise(screw_run(a)) for a in AMPLITUDES)
    assumed = f"assumed: theta of 3 deg (with 2 deg {{}}), balls {1e6 * source_cases.inferred_oversize():g} µm oversize"
    earlier = "; earlier than printed, see table friction-run-sensitivity"
    between = (
        f"{assumed.format(f'{100.0 * low.largest:.1f} %')}: the printed number lies between; the source's rule of contact"
    )
    words = f"{between}, which lets balls overlap, gives less (table friction-run-sensitivity); {steps_in_words(3.0)}"
    sheet.number("largest", 100.0 * high.largest, words)
    sheet.number("largest_at", high.at, assumed.format(f"{low.at:.0f}°") + earlier)
    sheet.number("none_at", high.none_at, assumed.format(f"{low.none_at:.0f}°") + earlier)


def _claims_of_run(sheet: Sheet) -> None:
    low, high = (summarise(screw_run(a)) for a in AMPLITUDES)
    words = f"{low.groups} groups with 2 deg, {high.groups} with 3 deg"
    sheet.claim("groups", low.groups == high.groups == 4, words)
    vary = [low.groove_variation, high.groove_variation]
    loose = loose_run()
    sheet.claim(
        "groove_steady",
        max(vary) < 0.03,
        f"largest less smallest over mean: {vary[0]:.1%} with 2 deg, {vary[1]:.1%} with 3 deg; without oversize, loads "
        f"coupled to friction, {variation(loose):.1%} from the second step on and {summarise(loose).groove_variation:.0%} "
        "with the first, whose loads are computed without friction: mostly the start, not third contacts that come and go",
    )
    again = [engages_again(screw_run(a)) for a in AMPLITUDES]
    sheet.claim("none_then_again", all(again), "with 2 and with 3 deg")


def table_4_2(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Table 4.2: inputs; dimensions that enter no model here stay open."""
    four, double = source_cases.four_point(tilt=False), source_cases.double_row(tilt=False)
    g = four.groove
    values = {
        "pitch_diameter": 2e3 * g.pitch_radius,
        "beta": degrees(g.contact_angle),
        "nu": g.poisson,
        "force": four.force,
        "speed": g.screw_speed / (2.0 * np.pi),
    }
    for key, case in (("4p", four), ("dr", double)):
        values |= {
            f"ball_{key}": 1e3 * case.groove.ball_radius,
            f"groove_{key}": 1e3 * case.groove.groove_radius,
            f"balls_{key}": case.count,
        }
    sheet.numbers(values)
    _modulus(sheet, g.young)
    apart = 2e3 * (double.rows[1].place - double.rows[0].place)
    sheet.number("thickness_dr", float(apart), "only twice the distance of the rows, an assumption")
    for key in ("outer_diameter", "inner_diameter", "thickness_4p"):
        sheet.words(key, "enters no model here: nothing to compare")


def section_4_3(sheet: Sheet, study: Study) -> None:
    """4.3.1 and the conclusion of 4.3.2 carried through to ball-to-ball contact."""
    _bearings(sheet)
    first = {(e, i): degrees(onset(study, e, i).first) for e in ("pitch", "roundness") for i in (0.0, 0.9)}
    lost = {e: int((onset(study, e, 0.0).loaded == 0.0).sum()) for e in ("pitch", "roundness")}
    sheet.claim(
        "roundness_quicker",
        all(first["roundness", i] < first["pitch", i] for i in (0.0, 0.9)),
        f"first meeting within {first['roundness', 0.0]:.1f} deg of the nut if lost balls stand, "
        f"{first['roundness', 0.9]:.0f} deg at 0.9 of the nominal velocity; with pitch error "
        f"{first['pitch', 0.0]:.0f} deg; {lost['roundness']} balls lost against {lost['pitch']}",
    )


def _bearings(sheet: Sheet) -> None:
    four, double = curve("4P", True), curve("DR", True)
    ratios = cut(four, 18.0), cut(double, 18.0), cut(curve("DR", False), 18.0)
    at_18 = int(four.four[np.searchsorted(four.angle, radians(18.0) * (1.0 - 1e-12))])
    still = cut(curve("4P", False), 18.0)
    words = f"load angles of 0 to 18 deg, inner ring free to tilt; {still:.2f} where it cannot tilt"
    sheet.number("ratio_4p", ratios[0], words)
    sheet.claim("four_worse", ratios[0] > 3.0 * max(ratios[1:]), f"{ratios[0]:.2f} against {ratios[1]:.2f}")
    sheet.claim(
        "dr_consistent",
        bool(np.all(double.four == 0)) and ratios[1] < 1.28,
        f"never more than two contacts a ball; ratio {ratios[1]:.2f} with tilt, {ratios[2]:.2f} without",
    )
    sheet.claim(
        "transition",
        bool(four.four[0] == 0 and at_18 > 0),
        f"{int(four.four[0])} balls beyond two contacts at 0 deg, {at_18} of {source_cases.four_point().count} at 18 deg",
    )
