"""Computed values for the numbers and claims printed by Liu et al. (2025) on a ball screw with random ball errors.

Sections 2, 3, 4.1 and 4.2: inputs, algorithm, experiment, Mei's model, one ball too small or too large. Sections 4.3 and
4.4: random errors; each printed number is given as a percentile among random screws, drawn from the stated distribution of
errors. Printed data: ``printed/liu-*``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product
from math import cos, degrees, sin

import numpy as np

from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import PrintedEntry
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.as_source.liu import chain as ball_chain
from rollbench.lowfi.as_source.liu import ensemble as screw_ensemble
from rollbench.lowfi.as_source.liu.elimination import solve_by_elimination
from rollbench.lowfi.as_source.liu.model import nut_as_spring_row
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene

#: Assumptions where the publication leaves an input open.
ASSUMED = (
    "Young's modulus 205 GPa and Poisson's ratio 0.3 for balls and nut too: E' is not printed.",
    "Areas of screw and nut and balls a turn are not printed. Only the compliance of a segment enters; it is calibrated "
    "once, so that Q78/Q1 without errors at 5000 N is 0.862.",
    "Stiffness is the tangent dF/du at the loaded end: the step of load of (22) is not printed.",
    "Drawn errors are independent and uniform in +-e; the errors that Liu et al. drew are not printed.",
)

#: Number of screws drawn with random errors; seed of the random numbers.
MEMBERS, SEED = 5000, 2025

#: Axial loads [N] under which random screws are solved, by half range of their ball errors [um].
LOADS: dict[int, tuple[float, ...]] = dict.fromkeys((1, 3), (100.0, 500.0, 1000.0, 2137.0, 3000.0, 5000.0))

LOADS[2] = (100.0, 500.0, 1000.0, 1100.0, 1500.0, 2000.0, 2100.0, 2137.0, 3000.0, 5000.0)

#: Probability below which a printed number is judged not to come from the stated distribution of errors.
UNLIKELY = 0.005


def liu_screw_scene() -> Scene:
    """Return the scene of Liu's ball screw (Table 2 and section 3.2.1), under the load of section 4.1."""
    return catalogue.scene("liu-screw")


@cache
def ball_count() -> int:
    """Return the number of balls of Liu's ball screw: 78."""
    return liu_screw_scene().ball_count


def calibration_load() -> float:
    """Return the axial load [N] at which the model's compliance is calibrated: the load of Liu's section 4.1."""
    return liu_screw_scene().loads[0].force[2]


@cache
def calibrated_model(contact_angle_law: ball_chain.Law = "implicit") -> ball_chain.BallScrewChain:
    """Return Liu's axial model of the screw with the segment stiffness of its scene, which is fitted to the ratio Q78/Q1.

    ``contact_angle_law``: contact-angle law: "implicit" (Liu's), for which the scene's value is fitted; "exact" or
    "constant", whose compliance is fitted to the same load ratio.
    """
    chain = nut_as_spring_row(liu_screw_scene(), law=contact_angle_law).liu_chain
    if contact_angle_law == "implicit":
        return chain
    ratio = ball_chain.last_to_first_load_ratio(calibrated_model(), calibration_load())
    return ball_chain.calibrate_compliance(chain, ratio, calibration_load())


def implied_series_cross_section(balls_a_turn: float) -> float:
    """Return the cross section [m^2] of nut and screw in series, 1/(1/A_n + 1/A_s), that the calibrated model implies.

    A_n, A_s: cross sections of nut and screw. ``balls_a_turn``: number of balls in a turn, which determines the length of a
    segment between two balls.
    """
    scene = liu_screw_scene()
    return scene.track.lead / balls_a_turn / (scene.balls.material.youngs_modulus * calibrated_model().compliance)


def ball_errors_with_faulty_ball_33(error: float) -> Array:
    """Return the diameter errors (78,) [m] of all balls, where only ball 33 has the given ``error``."""
    errors = np.zeros(ball_count())
    errors[32] = error
    return errors


@cache
def solve_with_error_of_ball_33(
    error_um: float, load: float, chain: ball_chain.BallScrewChain | None = None
) -> ball_chain.BallScrewState:
    """Solve the contact loads of the screw under an axial load, where only ball 33 has an error.

    ``error_um``: error of the ball's diameter [um]; ``load``: axial load [N]; ``chain``: axial model; None: Liu's model,
    calibrated.
    """
    return ball_chain.solve_ball_screw(chain or calibrated_model(), ball_errors_with_faulty_ball_33(1e-6 * error_um), load)


@cache
def solve_screws_with_random_errors(half_range_um: int) -> screw_ensemble.ScrewEnsemble:
    """Draw 5000 screws (`MEMBERS`) with random ball errors, and solve their contact loads under several axial loads.

    The loads are `LOADS`. ``half_range_um``: the errors of the ball diameters are uniform within plus and minus this range
    [um].
    """
    return _solve_random_screws(half_range_um, LOADS[half_range_um])


def _solve_random_screws(half_range_um: int, loads: Sequence[float]) -> screw_ensemble.ScrewEnsemble:
    """Solve `MEMBERS` screws whose ball errors are uniform within a half range [um], under the axial ``loads`` [N]."""
    seed = SEED + half_range_um
    return screw_ensemble.solve_ensemble(calibrated_model(), 1e-6 * half_range_um, list(loads), MEMBERS, seed=seed)


def random_screw_values(half_range_um: int, quantity: screw_ensemble.Quantity, load: float) -> Array:
    """Return one quantity of all randomly drawn screws under an axial load, (n,) in SI units for n screws.

    ``half_range_um``: half range of the ball errors [um]; ``quantity``: name, such as "stiffness"; ``load``: axial load
    [N], one of `LOADS`.
    """
    return solve_screws_with_random_errors(half_range_um).values_at(quantity, load)


def percentile_with_words(
    values: Array, printed: float, half_step_of_last_digit: float
) -> tuple[screw_ensemble.PercentileRank, str]:
    """Return the percentile of a printed number among randomly drawn screws, then the same in words.

    ``values``: computed values of these screws, in the unit of the printed number; ``half_step_of_last_digit``: half a step
    of the printed number's last digit.
    """
    p = screw_ensemble.percentile_rank(values, printed, half_step_of_last_digit)
    low, high = np.quantile(values, [UNLIKELY, 1.0 - UNLIKELY])
    words = (
        f"percentile {p.percent:.1f} ± {p.standard_error:.1f} of {p.size} drawn screws, median {np.median(values):.4g}, "
    )
    words += f"central 99 % {low:.4g} to {high:.4g}; as far out: probability {p.tail_probability:.4f}"
    return p, words + (f", at most {p.tail_bound:.4f} (95 %)" if p.tail_probability < UNLIKELY else "")


#: Number of randomly drawn screws on which the Newton method and the elimination are compared.
FEW = 20

#: Axial loads [N] under which the error of a single ball is studied (section 4.2).
LIGHT, HEAVY = 1000.0, 5000.0


def section_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 2.1 and Table 2 of Liu et al. (2025), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    scene = liu_screw_scene()
    track, balls, angle, lead = scene.track, scene.balls, scene.track.contact_angle, lead_angle(scene.track)
    mm = {"R": track.pitch_radius, "D": 2.0 * balls.radius, "P_h": track.lead, "r": scene.screw.groove_radius}
    findings.numbers({key: 1e3 * value for key, value in mm.items()})
    steel = {"E": 1e-9 * balls.material.youngs_modulus, "nu": balls.material.poissons_ratio}
    findings.numbers({"alpha_0": degrees(angle), "M": float(scene.ball_count), **steel})
    findings.add_number("lead_angle", degrees(lead), "from pitch and radius")
    parts = {key: findings.printed(key) for key in ("v_2pi", "ball_error", "profile_error")}
    findings.numbers(parts)
    right = parts["v_2pi"] * sin(angle) * cos(lead) + parts["ball_error"] + parts["profile_error"]
    findings.add_number("range", None, as_printed=sum(parts.values()), follows=right)
    findings.numbers({f"e_{h}": float(h) for h in LOADS})
    findings.add_claim("plus_or_minus", False, "the plus sign draws in [e, 3 e], the minus sign in [-e, e]")


def compare_with_elimination() -> tuple[int, int, float]:
    """Compare the Newton method with Liu's elimination of unloaded balls, on 20 randomly drawn screws at 500 N.

    Returns, in this order: the number of screws with the same loaded balls by both; the largest number of rounds that the
    elimination takes; the largest difference of a ball's load between both methods, over the screw's largest load.
    """
    errors = screw_ensemble.draw_uniform_errors(SEED, 0, FEW, ball_count(), 2e-6)
    same, rounds, worst = 0, 0, 0.0
    for e in errors:
        ours = ball_chain.solve_ball_screw(calibrated_model(), e, 500.0)
        other = solve_by_elimination(calibrated_model(), e, 500.0)
        same += int(other.converged and np.array_equal(ours.load > 0.0, other.contact_loads > 0.0))
        rounds = max(rounds, other.rounds)
        worst = max(worst, float(np.abs(ours.load - other.contact_loads).max() / ours.load.max()))
    return same, rounds, worst


def section_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 3 of Liu et al. (2025), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    errors = screw_ensemble.draw_uniform_errors(SEED, 0, FEW, ball_count(), 2e-6)
    steps = max(ball_chain.solve_ball_screw(calibrated_model(), x, 500.0).iterations for x in errors)
    same, rounds, worst = compare_with_elimination()
    words = (
        f"on the convex energy at most {steps} steps for {FEW} screws at 500 N; the elimination's loaded balls are "
        f"the same in {same} of {FEW}, in up to {rounds} rounds, loads to {worst:.0e}"
    )
    findings.add_claim("newton", False, words)
    loaded = {f: random_screw_values(2, "loaded", f) for f in (500.0, 1000.0, 1500.0, 2000.0)}
    share = float(np.mean(loaded[2000.0] == ball_count()))
    findings.add_claim("all_2000", share >= UNLIKELY, f"probability {share:.3f}")
    for key, load in (("unloaded_1500", 1500.0), ("unloaded_500", 500.0)):
        sample = ball_count() - loaded[load]
        findings.add_number(key, float(np.median(sample)), percentile_with_words(sample, findings.printed(key), 0.0)[1])
    exactly = [f"{np.mean(loaded[f] == ball_count() - 1):.3f} at {f:g} N" for f in (1000.0, 1500.0)]
    findings.add_remark("caption_1000", f"probability of exactly one: {', '.join(exactly)}")
    findings.numbers({"load": findings.printed("load"), "free_length": findings.printed("free_length")})
    ratio = random_screw_values(3, "smallest", 3000.0) / random_screw_values(3, "largest", 3000.0)
    low, high = np.quantile(ratio, [UNLIKELY, 1.0 - UNLIKELY])
    words = f"smallest over largest load {low:.2f} to {high:.2f} (central 99 %) at 3000 N"
    findings.add_claim("uniform_3000", low > 0.5, words)
    medians = [float(np.median(random_screw_values(3, "stiffness", f))) / 1e8 for f in LOADS[3]]
    words = f"{', '.join(f'{v:.2f}' for v in medians)} 1e8 N/m from 100 to 5000 N (medians, ±3 um)"
    findings.add_claim("falls", bool(np.all(np.diff(medians) < 0.0)), words)


def mei_model() -> ball_chain.BallScrewChain:
    """Return Mei's axial model as Liu et al. use it: contact angles constant at 45 deg, compliance as in Liu's model."""
    return replace(calibrated_model(), law="constant")


def largest_deviations_from_mei_percent(
    chain: ball_chain.BallScrewChain, errors: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> tuple[float, float]:
    """Return the largest difference [%] of any ball's load between an axial model and Mei's model, at 5000 N.

    First: relative to the load by Mei's model; second: relative to the load by the other model. ``chain``: the other
    model; ``errors``: errors of the ball diameters (78,) [m].
    """
    load = ball_chain.solve_ball_screw(chain, errors, calibration_load()).load
    mei = ball_chain.solve_ball_screw(replace(chain, law="constant"), errors, calibration_load()).load
    return float(100.0 * np.abs(1.0 - load / mei).max()), float(100.0 * np.abs(mei / load - 1.0).max())


def section_4_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 4.1 of Liu et al. (2025), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    load = calibration_load()
    area = 1e6 * implied_series_cross_section(26.0)
    words = f"compliance of a segment {calibrated_model().compliance:.4g} m/N"
    words += f": with 26 balls a turn, areas in series 1/(1/A_n + 1/A_s) = {area:.0f} mm2"
    findings.add_number("ratio", ball_chain.last_to_first_load_ratio(calibrated_model(), load), words)
    exact = ball_chain.last_to_first_load_ratio(replace(calibrated_model("exact"), law="constant"), load)
    words = f"beside the exact contact angle it would be {exact:.4f}"
    findings.add_number("ratio_mei", ball_chain.last_to_first_load_ratio(mei_model(), load), words)
    zero = np.zeros(ball_count())
    found = [x for law in ("implicit", "exact") for x in largest_deviations_from_mei_percent(calibrated_model(law), zero)]
    words = "implicit {:.2f} of Mei's, {:.2f} of its own load; exact {:.2f}, {:.2f}".format(*found)
    findings.add_number("deviation", found[0], words)
    less = ball_chain.solve_ball_screw(mei_model(), zero, load).load - solve_with_error_of_ball_33(0.0, load).load
    findings.add_claim("smaller", bool(np.all(less > 0.0)), f"by {less.min():.2f} to {less.max():.2f} N")
    errors = screw_ensemble.draw_uniform_errors(SEED, 0, FEW, ball_count(), 2e-6)
    worst = [largest_deviations_from_mei_percent(calibrated_model(), x)[0] for x in errors]
    words = f"{min(worst):.2f} to {max(worst):.2f} % in {FEW} drawn screws"
    findings.add_claim("deviation_errors", max(worst) <= 2.875, words)


def last_over_first_ball_load_ratio(error_um: float, load: float) -> float:
    """Return the ratio Q78/Q1 of the loads of last and first ball, where only ball 33 has an error.

    ``error_um``: error of the diameter of ball 33 [um]; ``load``: axial load [N].
    """
    q = solve_with_error_of_ball_33(error_um, load).load
    return float(q[-1] / q[0])


def load_by_other_contact_angle_laws_in_words(error_um: float, load: float) -> str:
    """Return in words the load [N] of ball 33, once with exact contact angles and once with constant contact angles.

    The model is calibrated to the same ratio Q78/Q1 for each law. ``error_um``: error of the diameter of ball 33 [um];
    ``load``: axial load [N].
    """
    laws: tuple[ball_chain.Law, ...] = ("exact", "constant")
    found = {law: solve_with_error_of_ball_33(error_um, load, calibrated_model(law)).load[32] for law in laws}
    return "; ".join(f"{law} contact angle {value:.2f} N" for law, value in found.items())


def load_change_range_of_other_balls(error_um: float) -> list[float]:
    """Return the smallest, then the largest change [N] of the other balls' loads that an error of ball 33 causes.

    Both are extremes over all balls but ball 33 and over the axial loads `LIGHT` and `HEAVY`. ``error_um``: error of the
    diameter of ball 33 [um].
    """
    change = [
        np.delete(solve_with_error_of_ball_33(error_um, f).load - solve_with_error_of_ball_33(0.0, f).load, 32)
        for f in (LIGHT, HEAVY)
    ]
    return [float(np.min(change)), float(np.max(change))]


def error_of_ball_33_for_load(load: float) -> float:
    """Return the diameter error [um] of ball 33 at which this ball carries ``load`` [N] under an axial load of 5000 N."""
    return float(brentq(lambda e: solve_with_error_of_ball_33(e, HEAVY).load[32] - load, 0.0, 3.0, xtol=1e-6))


def section_4_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 4.2 of Liu et al. (2025), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    for name, error in (("minus", -2.0), ("plus", 2.0)):
        for load in (LIGHT, HEAVY):
            q = float(solve_with_error_of_ball_33(error, load).load[32])
            findings.add_number(f"{name}_Q33_{load:.0f}", q, load_by_other_contact_angle_laws_in_words(error, load))
            findings.add_number(f"{name}_ratio_{load:.0f}", last_over_first_ball_load_ratio(error, load))
    q = float(solve_with_error_of_ball_33(2.0, HEAVY).load[32])
    words = (
        f"142.55 would be {100.0 * (142.55 / q - 1.0):+.2f} % off; 124.55 takes an error of "
        f"{error_of_ball_33_for_load(124.55):.2f} um"
    )
    findings.add_number("plus_Q33_5000", q, words)
    start = ball_chain.load_at_which_ball_is_loaded(calibrated_model(), ball_errors_with_faulty_ball_33(-2e-6), 32, HEAVY)
    words = f"loaded from {start:.0f} N on"
    findings.add_number("minus_Q33_1000", float(solve_with_error_of_ball_33(-2.0, LIGHT).load[32]), words)
    for name, sign in (("minus", -1.0), ("plus", 1.0)):
        low, high = load_change_range_of_other_balls(2.0 * sign)
        findings.add_claim(f"{name}_others", max(sign * low, sign * high) < 0.0, f"by {low:.3f} to {high:.3f} N")
    errors = ball_errors_with_faulty_ball_33(2e-6)
    begins = partial(ball_chain.load_at_which_ball_is_loaded, calibrated_model(), errors)
    first, last = (begins(k, LIGHT) for k in (0, ball_count() - 1))
    findings.add_claim("only_33", first > 0.0, f"up to {first:.2f} N; ball 78 carries from {last:.2f} N")
    minus, plus = ([last_over_first_ball_load_ratio(s, f) for f in (LIGHT, HEAVY)] for s in (-2.0, 2.0))
    words = ", ".join(f"{light:.4f} to {heavy:.4f}" for light, heavy in (minus, plus))
    findings.add_claim("ratio_falls", all(light > heavy for light, heavy in (minus, plus)), words)
    pairs = list(zip(plus, minus, strict=True))
    words = ", ".join(f"{a:.4f} at +2 um, {b:.4f} at -2 um" for a, b in pairs)
    findings.add_claim("plus_evens", all(a > b for a, b in pairs), words)


RANGES = (1, 2, 3)

NAMES: dict[str, screw_ensemble.Quantity] = {
    "max": "largest",
    "min": "smallest",
    "loaded": "loaded",
    "unloaded": "loaded",
    "K": "stiffness",
}

#: Load step over the load, at which the stiffness of equation (22) is compared with the tangent stiffness.
STEP = 0.12

#: Names of the three screws with errors of +-2 um in the publication, whose errors were drawn independently.
SETS = "abc"


def random_screw_values_for_printed_number(key: str) -> Array:
    """Return the quantity of a printed number for all randomly drawn screws (n,), in its printed unit.

    ``key``: key of the printed number: quantity, half range of the ball errors [um], and axial load [N], such as
    "K_2_3000".
    """
    name, which, load = key.removesuffix("_again").split("_")
    values = random_screw_values(2 if which in SETS else int(which), NAMES[name], float(load))
    if name == "unloaded":
        return ball_count() - values
    return 1e-8 * values if name == "K" else values


def screws_with_printed_counts_in_words(half_range: int, at_500: int, at_1000: int) -> str:
    """Return in words how many randomly drawn screws have the printed numbers of loaded balls at 500 N and 1000 N.

    ``half_range``: half range of the ball errors [um]; ``at_500``, ``at_1000``: printed numbers of loaded balls.
    """
    first, then = (random_screw_values(half_range, "loaded", f) for f in (500.0, 1000.0))
    some = then[np.abs(first - at_500) <= 1]
    reached = int(np.count_nonzero(some <= at_1000))
    return f"of {some.size} screws with {at_500} ± 1 loaded at 500 N, {reached} have at most {at_1000} at 1000 N"


def record_percentile(findings: ComputedEntryValues, key: str, *remarks: str) -> None:
    """Record in ``findings`` the median of a quantity over randomly drawn screws, to compare with a printed number.

    The remark states the percentile of the printed number among these screws. ``key``: key of the printed number;
    ``remarks``: further remarks.
    """
    row = next(f.printed for f in findings.comparisons() if f.printed.key == key)
    values = random_screw_values_for_printed_number(key)
    half = 0.0 if key.startswith(("loaded", "unloaded")) else row.tolerance
    words = percentile_with_words(values, findings.printed(key), half)[1]
    findings.add_number(key, float(np.median(values)), ". ".join((words, *remarks)))


def judge_fraction_of_screws(has_property: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[bool, str]:
    """Return whether at least the fraction `UNLIKELY` (0.5 %) of the randomly drawn screws has a property, then a text.

    The text states the fraction of the screws with the property, and its standard error. ``has_property``: for each screw,
    whether it has the property.
    """
    p = float(np.mean(has_property))
    return p >= UNLIKELY, f"probability {p:.3f} ± {np.sqrt(p * (1.0 - p) / has_property.size):.3f}"


def decreases_with_error_range(
    quantity: screw_ensemble.Quantity, load: float
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return for each randomly drawn screw (n,) whether a quantity falls when the half range of ball errors grows.

    The half ranges are 1, 2 and 3 um. ``quantity``: name of the quantity, such as "stiffness"; ``load``: axial load [N].
    """
    a, b, c = (random_screw_values(h, quantity, load) for h in RANGES)
    return np.asarray((a > b) & (b > c))


def section_4_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 4.3 of Liu et al. (2025) with randomly drawn screws; check its claims.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    for row in (f.printed for f in findings.comparisons()):
        if row.value is not None:
            record_percentile(findings, row.key)
    for key, at_500, at_1000 in (
        ("unloaded_2_1000", 53, 62),
        ("unloaded_2_1000_again", 53, 61),
        ("unloaded_3_1000", 42, 43),
    ):
        record_percentile(findings, key, screws_with_printed_counts_in_words(int(key.split("_")[1]), at_500, at_1000))
    every = [random_screw_values(h, "loaded", 2137.0) == ball_count() for h in RANGES]
    holds, words = judge_fraction_of_screws(np.logical_and.reduce(every))
    alone = ", ".join(f"{np.mean(m):.3f}" for m in every)
    findings.add_claim("all_2137", holds, f"{words} (singly {alone})")
    findings.add_claim("all_5000", *judge_fraction_of_screws(random_screw_values(2, "loaded", 5000.0) == ball_count()))
    fewer = decreases_with_error_range("loaded", 100.0) & decreases_with_error_range("loaded", 500.0)
    findings.add_claim("fewer", *judge_fraction_of_screws(fewer))
    both = product(RANGES, (1000.0, 5000.0))
    width = {(h, f): random_screw_values(h, "largest", f) - random_screw_values(h, "smallest", f) for h, f in both}
    grows = [width[h, 5000.0] > width[h, 1000.0] for h in RANGES]
    grows += [width[h + 1, f] > width[h, f] for h in (1, 2) for f in (1000.0, 5000.0)]
    findings.add_claim("wider", *judge_fraction_of_screws(np.logical_and.reduce(grows)))
    a, b, c = (random_screw_values(h, "displacement_first_loaded", 1000.0) for h in RANGES)
    findings.add_claim("further", *judge_fraction_of_screws((a < b) & (b < c)))
    _check_displacement_claims(findings)


def _check_displacement_claims(findings: ComputedEntryValues) -> None:
    """Check Liu's claims on displacement over load by the medians of randomly drawn screws.

    ``findings``: receives the results.
    """
    loads = np.array(LOADS[1])
    curve = np.array([[np.median(random_screw_values(h, "displacement", f)) for f in loads] for h in RANGES])
    power = np.diff(np.log(curve[1])) / np.diff(np.log(loads))
    words = f"a power between {power.min():.2f} and {power.max():.2f} of the load: it grows ever more slowly"
    findings.add_claim("exponential", bool(power.min() > 1.0), words)
    apart = 1e6 * np.diff(curve, axis=0)
    words = "; ".join(", ".join(f"{v:.2f}" for v in row) for row in apart) + " um from 100 to 5000 N (medians), "
    grown = " and ".join(f"{100.0 * (row[-1] / row[-2] - 1.0):.1f}" for row in apart)
    findings.add_remark("parallel", f"{words}by {grown} % still from 3000 to 5000 N")


def stiffness_spreads_of_triples(load: float) -> Array:
    """Return the largest minus the smallest stiffness [1e8 N/m] in each group of three randomly drawn screws, (groups,).

    The ball errors are within ±2 um. ``load``: axial load [N].
    """
    values = 1e-8 * random_screw_values(2, "stiffness", load)
    return np.asarray(np.ptp(values[: values.size // 3 * 3].reshape(-1, 3), axis=1))


def relative_stiffness_percentile_in_words(key: str, printed: float, reference: float) -> str:
    """Return in words the percentile of a printed stiffness ratio (with/without ball errors) among randomly drawn screws.

    The ratio is the printed stiffness with random ball errors over that without errors; a factor common to all computed
    stiffnesses does not change it. ``key``: key of the printed stiffness; ``printed``: its value; ``reference``: printed
    stiffness without errors.
    """
    h, load = int(key.split("_")[1]), float(key.split("_")[2])
    without = solve_with_error_of_ball_33(0.0, load).stiffness
    ratio = random_screw_values(h, "stiffness", load) / without
    return "over the value without errors: " + percentile_with_words(ratio, printed / reference, 0.0)[1]


def secant_stiffness_without_errors(load: float, step: float) -> float:
    """Return the stiffness [1e8 N/m] of the screw without errors by equation (22) of Liu et al. (2025).

    ``load``: axial load [N]; ``step``: load step over which the stiffness is a secant [N]; 0: tangent stiffness.
    """
    if step == 0.0:
        return float(1e-8 * solve_with_error_of_ball_33(0.0, load).stiffness)
    moved = [solve_with_error_of_ball_33(0.0, f).displacement for f in (load, load + step)]
    return float(1e-8 * step / (moved[1] - moved[0]))


@cache
def secant_stiffness_of_drawn_screws(half_range_um: int, load: float, relative_load_step: float) -> Array:
    """Return the secant stiffness [1e8 N/m] of all randomly drawn screws, (n,) for n screws.

    ``half_range_um``: half range of the ball errors [um]; ``load``: axial load [N]; ``relative_load_step``: load step of
    the secant over the load; 0: tangent stiffness.
    """
    if relative_load_step == 0.0:
        return 1e-8 * random_screw_values(half_range_um, "stiffness", load)
    ends = [load, (1.0 + relative_load_step) * load]
    found = _solve_random_screws(half_range_um, ends)
    first, last = (found.values_at("displacement", f) for f in ends)
    return np.asarray(1e-8 * relative_load_step * load / (last - first))


def printed_stiffness_agrees(row: PrintedEntry, relative_load_step: float) -> bool:
    """Return whether a printed stiffness lies in the range of the secant stiffness of randomly drawn screws.

    ``row``: printed number; ``relative_load_step``: load step of the secant over the load; 0: tangent stiffness. A
    stiffness without errors must agree with the computed one to 1 %, as the publication's other results do.
    """
    _, which, load = row.key.split("_")
    assert row.value is not None
    if which == "0":
        return abs(row.value / secant_stiffness_without_errors(float(load), relative_load_step * float(load)) - 1.0) <= 0.01
    values = secant_stiffness_of_drawn_screws(2 if which in SETS else int(which), float(load), relative_load_step)
    return bool(values.min() - row.tolerance <= row.value <= values.max() + row.tolerance)


def stiffness_agreement_in_words(rows: Sequence[PrintedEntry]) -> str:
    """Return in words how many printed stiffnesses agree with the tangent stiffness, and how many with a secant stiffness.

    ``rows``: printed stiffnesses; the load step of the secant is `STEP` times the load.
    """
    counts = [sum(printed_stiffness_agrees(row, share) for row in rows) for share in (0.0, STEP)]
    return (
        f"the load step of (22) is not printed: {counts[0]} of {len(rows)} stiffnesses agree with the tangent, and "
        f"{counts[1]} with a secant over a step of {100.0 * STEP:g} % of the load"
    )


def section_4_4(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in section 4.4 of Liu et al. (2025) with randomly drawn screws; check its claims.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    bare = findings.printed("K_0_3000")
    printed_K = [f.printed for f in findings.comparisons() if f.printed.key.startswith("K_")]
    for row in printed_K:
        if row.value is not None and row.key != "K_0_3000":
            near = row.key.endswith("_3000")
            remarks = [relative_stiffness_percentile_in_words(row.key, row.value, bare)] if near else []
            record_percentile(findings, row.key, *remarks)
    laws = "exact", "constant"
    other = {law: 1e-8 * solve_with_error_of_ball_33(0.0, 3000.0, calibrated_model(law)).stiffness for law in laws}
    words = "; ".join(f"{law} contact angle {value:.3f}" for law, value in other.items())
    words = (
        f"{words}; by a step of {100.0 * STEP:g} % of the load "
        f"{secant_stiffness_without_errors(3000.0, STEP * 3000.0):.3f}; {stiffness_agreement_in_words(printed_K)}"
    )
    findings.add_number("K_0_3000", secant_stiffness_without_errors(3000.0, 0.0), words)
    for load in (100, 1100, 2100):
        printed = [findings.printed(f"K_{s}_{load}") for s in SETS]
        _, words = percentile_with_words(stiffness_spreads_of_triples(float(load)), max(printed) - min(printed), 0.0005)
        findings.add_number(f"spread_{load}", None, words.replace("screws", "triples"), follows=max(printed) - min(printed))
    low = min(findings.printed(f"K_{s}_1100") for s in SETS)
    findings.follow({"spread_percent": 100.0 * findings.printed("spread_1100") / low})
    _check_stiffness_claims(findings)


def _check_stiffness_claims(findings: ComputedEntryValues) -> None:
    """Check Liu's claims on the stiffness of screws with random errors, section 4.4; ``findings``: receives the results."""
    s = {load: stiffness_spreads_of_triples(load) for load in (100.0, 1100.0, 2100.0)}
    findings.add_claim("largest_1100", *judge_fraction_of_screws((s[1100.0] > s[100.0]) & (s[1100.0] > s[2100.0])))
    percent = 100.0 * s[100.0] / (1e-8 * np.median(random_screw_values(2, "stiffness", 100.0)))
    median, printed = np.median(percent), 100.0 * findings.printed("spread_100") / findings.printed("K_a_100")
    words = f"three draws differ by {median:.0f} % at 100 N in the median; its own by {printed:.1f} %"
    findings.add_claim("minimal", bool(median <= 4.31), words)
    rises = [np.diff(np.stack([random_screw_values(h, "stiffness", f) for f in LOADS[h]]), axis=0) > 0.0 for h in RANGES]
    words = f"in all of {3 * MEMBERS} drawn screws, {LOADS[1][0]:.0f} to 5000 N"
    findings.add_claim("rises", all(bool(r.all()) for r in rises), words)
    findings.add_claim("softer", *judge_fraction_of_screws(decreases_with_error_range("stiffness", 500.0)))
    free = solve_with_error_of_ball_33(0.0, 3000.0).stiffness
    off = [100.0 * (np.median(random_screw_values(h, "stiffness", 3000.0)) / free - 1.0) for h in RANGES]
    findings.add_remark("meet", ", ".join(f"{x:.1f}" for x in off) + " % in the median of drawn screws")
