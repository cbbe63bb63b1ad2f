"""Liu et al. (2025): the computed value beside every printed number and claim, with evidence.

The ball screw, its one calibration, and the screws drawn from its distribution of errors; sections 2, 3, 4.1 and 4.2
(inputs, the algorithm, the experiment, Mei's model, one ball too small or too large); sections 4.3 and 4.4 (random errors,
by the place of each printed number among drawn screws). Printed data: ``printed/liu-*``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import cos, degrees, sin

import numpy as np

from rollbench.compare.evidence import Findings
from rollbench.compare.models.study import Study
from rollbench.compare.printed import Printed, value_of
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.random_errors.chain import (
    Chain,
    ChainState,
    Ensemble,
    Law,
    PercentileRank,
    Quantity,
    calibrate_compliance,
    draw_errors,
    end_ratio,
    first_carrying_load,
    percentile_rank,
    solve_chain,
    solve_ensemble,
)
from rollbench.lowfi.random_errors.elimination import solve_by_elimination
from rollbench.lowfi.statics.liu import row_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene

#: What the source leaves open.
ASSUMED = (
    "Young's modulus 205 GPa and Poisson's ratio 0.3 for balls and nut too: E' is not printed.",
    "Areas of screw and nut and balls a turn are not printed. Only the compliance of a segment enters; it is calibrated "
    "once, so that Q78/Q1 without errors at 5000 N is 0.862.",
    "Stiffness is the tangent dF/du at the loaded end: the step of load of (22) is not printed.",
    "Drawn errors are independent and uniform in +-e; the draws of the source are not printed.",
)

#: Drawn screws; seed; loads at which they are solved [N].
MEMBERS, SEED = 5000, 2025

LOADS: dict[int, tuple[float, ...]] = {
    1: (100.0, 500.0, 1000.0, 2137.0, 3000.0, 5000.0),
    3: (100.0, 500.0, 1000.0, 2137.0, 3000.0, 5000.0),
}

LOADS[2] = (100.0, 500.0, 1000.0, 1100.0, 1500.0, 2000.0, 2100.0, 2137.0, 3000.0, 5000.0)

#: Probability below which a number is said not to come from the stated distribution.
UNLIKELY = 0.005


def liu_screw() -> Scene:
    """Return the screw of Table 2 and section 3.2.1; its load is that of section 4.1."""
    return catalogue.scene("liu-screw")


@cache
def balls() -> int:
    """Return the number of balls of the screw."""
    return liu_screw().ball_count


@cache
def printed_ratio() -> float:
    """Return Q78/Q1 without errors (section 4.1), the input to which the chain's compliance is calibrated."""
    return value_of("liu-4.1", "ratio")


def calibration_load() -> float:
    """Return the load [N] at which the chain is calibrated, that of section 4.1 and of the scene."""
    return liu_screw().loads[0].force[2]


@cache
def screw(law: Law = "implicit") -> Chain:
    """Return the calibrated chain under one interpretation of the contact angle; the source uses "implicit"."""
    return calibrate_compliance(row_of(liu_screw(), law=law).chain, printed_ratio(), calibration_load())


def implied_area(balls_a_turn: float) -> float:
    """Return the area [m^2] of screw and nut in series, 1/(1/A_n + 1/A_s), that the calibration implies."""
    scene = liu_screw()
    return scene.track.lead / balls_a_turn / (scene.balls.material.youngs_modulus * screw().compliance)


def one_error(error: float) -> Array:
    """Return ball errors [m] that are zero except for ball 33."""
    errors = np.zeros(balls())
    errors[32] = error
    return errors


@cache
def single_error_state(error_um: float, load: float, chain: Chain | None = None) -> ChainState:
    """Solve the chain with a diameter error [um] at ball 33 only, under an axial load [N]."""
    return solve_chain(chain or screw(), one_error(1e-6 * error_um), load)


@cache
def drawn_ensemble(half_range_um: int) -> Ensemble:
    """Return the screws drawn with errors within +-half_range [um]; each range has its own draws."""
    return solve_ensemble(screw(), 1e-6 * half_range_um, list(LOADS[half_range_um]), MEMBERS, seed=SEED + half_range_um)


def drawn_sample(half_range_um: int, quantity: Quantity, load: float) -> Array:
    """Return the values (n,) of one quantity of the drawn screws under a load [N]."""
    return drawn_ensemble(half_range_um).values_at(quantity, load)


def place_in(values: Array, printed: float, half_digit: float) -> tuple[PercentileRank, str]:
    """Return the percentile of a printed number in a sample, and the sentence that states it."""
    p = percentile_rank(values, printed, half_digit)
    low, high = np.quantile(values, [UNLIKELY, 1.0 - UNLIKELY])
    words = f"percentile {p.middle:.1f} ± {p.error:.1f} of {p.size} drawn screws, median {np.median(values):.4g}, "
    words += f"central 99 % {low:.4g} to {high:.4g}; as far out: probability {p.tail:.4f}"
    return p, words + (f", at most {p.tail_bound:.4f} (95 %)" if p.tail < UNLIKELY else "")


#: Drawn screws on which the two algorithms are compared, or that are solved one by one.
FEW = 20

#: Loads [N] under which a ball is off by 2 um.
LIGHT, HEAVY = 1000.0, 5000.0


def section_2(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 2.1 and Table 2."""
    scene = liu_screw()
    track, balls, angle, lead = scene.track, scene.balls, scene.track.contact_angle, lead_angle(scene.track)
    mm = {"R": track.pitch_radius, "D": 2.0 * balls.radius, "P_h": track.lead, "r": scene.screw.groove_radius}
    e.numbers({key: 1e3 * value for key, value in mm.items()})
    steel = {"E": 1e-9 * balls.material.youngs_modulus, "nu": balls.material.poissons_ratio}
    e.numbers({"alpha_0": degrees(angle), "M": float(scene.ball_count), **steel})
    e.number("lead_angle", degrees(lead), "from pitch and radius")
    parts = [e.printed(key) for key in ("v_2pi", "ball_error", "profile_error")]
    e.numbers(dict(zip(("v_2pi", "ball_error", "profile_error"), parts, strict=True)))
    right = parts[0] * sin(angle) * cos(lead) + parts[1] + parts[2]
    e.number("range", right, as_printed=sum(parts))
    e.numbers({f"e_{h}": float(h) for h in LOADS})
    e.claim("plus_or_minus", False, "the plus sign draws in [e, 3 e], the minus sign in [-e, e]")


def loosest_agreement() -> tuple[int, int, float]:
    """Return the number of screws with equal loaded balls by both algorithms, most rounds, largest difference."""
    errors = draw_errors(SEED, 0, FEW, balls(), 2e-6)
    same, rounds, worst = 0, 0, 0.0
    for e in errors:
        ours, other = solve_chain(screw(), e, 500.0), solve_by_elimination(screw(), e, 500.0)
        same += int(other.converged and np.array_equal(ours.load > 0.0, other.load > 0.0))
        rounds = max(rounds, other.rounds)
        worst = max(worst, float(np.abs(ours.load - other.load).max() / ours.load.max()))
    return same, rounds, worst


def section_3(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 3."""
    steps = max(solve_chain(screw(), x, 500.0).iterations for x in draw_errors(SEED, 0, FEW, balls(), 2e-6))
    same, rounds, worst = loosest_agreement()
    e.claim(
        "newton",
        False,
        f"on the convex energy at most {steps} steps for {FEW} screws at 500 N; the elimination's loaded balls are "
        f"the same in {same} of {FEW}, in up to {rounds} rounds, loads to {worst:.0e}",
    )
    loaded = {f: drawn_sample(2, "loaded", f) for f in (500.0, 1000.0, 1500.0, 2000.0)}
    share = float(np.mean(loaded[2000.0] == balls()))
    e.claim("all_2000", share >= UNLIKELY, f"probability {share:.3f}")
    for key, load in (("unloaded_1500", 1500.0), ("unloaded_500", 500.0)):
        sample = balls() - loaded[load]
        e.number(key, float(np.median(sample)), place_in(sample, e.printed(key), 0.0)[1])
    exactly = {f: float(np.mean(loaded[f] == balls() - 1)) for f in (1000.0, 1500.0)}
    e.remark("caption_1000", "probability of exactly one: {:.3f} at 1000 N, {:.3f} at 1500 N".format(*exactly.values()))
    e.numbers({"load": e.printed("load"), "free_length": e.printed("free_length")})
    ratio = drawn_sample(3, "smallest", 3000.0) / drawn_sample(3, "largest", 3000.0)
    low, high = np.quantile(ratio, [UNLIKELY, 1.0 - UNLIKELY])
    e.claim("uniform_3000", low > 0.5, f"smallest over largest load {low:.2f} to {high:.2f} (central 99 %) at 3000 N")
    medians = [float(np.median(drawn_sample(3, "stiffness", f))) / 1e8 for f in LOADS[3]]
    words = ", ".join(f"{v:.2f}" for v in medians)
    e.claim("falls", bool(np.all(np.diff(medians) < 0.0)), f"{words} 1e8 N/m from 100 to 5000 N (medians, ±3 um)")


def mei() -> Chain:
    """Return Mei's model as the source uses it: contact angle 45 deg, compliance of the source's model."""
    return replace(screw(), law="constant")


def mei_deviations(chain: Chain, errors: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[float, float]:
    """Return the largest deviation of a chain's loads from Mei's at 5000 N [%], over Mei's load and over the chain's."""
    load = solve_chain(chain, errors, calibration_load()).load
    mei = solve_chain(replace(chain, law="constant"), errors, calibration_load()).load
    return float(100.0 * np.abs(1.0 - load / mei).max()), float(100.0 * np.abs(mei / load - 1.0).max())


def section_4_1(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 4.1."""
    load = calibration_load()
    area = 1e6 * implied_area(26.0)
    words = f"compliance of a segment {screw().compliance:.4g} m/N"
    words += f": with 26 balls a turn, areas in series 1/(1/A_n + 1/A_s) = {area:.0f} mm2"
    e.number("ratio", end_ratio(screw(), load), words)
    exact = end_ratio(replace(screw("exact"), law="constant"), load)
    e.number("ratio_mei", end_ratio(mei(), load), f"beside the exact contact angle it would be {exact:.4f}")
    zero = np.zeros(balls())
    found = [x for law in ("implicit", "exact") for x in mei_deviations(screw(law), zero)]
    e.number("deviation", found[0], "implicit {:.2f} of Mei's, {:.2f} of its own load; exact {:.2f}, {:.2f}".format(*found))
    less = solve_chain(mei(), zero, load).load - single_error_state(0.0, load).load
    e.claim("smaller", bool(np.all(less > 0.0)), f"by {less.min():.2f} to {less.max():.2f} N")
    errors = draw_errors(SEED, 0, FEW, balls(), 2e-6)
    worst = [mei_deviations(screw(), x)[0] for x in errors]
    e.claim("deviation_errors", max(worst) <= 2.875, f"{min(worst):.2f} to {max(worst):.2f} % in {FEW} drawn screws")


def ratio(error_um: float, load: float) -> float:
    """Return the load ratio Q78/Q1 with an error [um] of ball 33 under a load [N]."""
    q = single_error_state(error_um, load).load
    return float(q[-1] / q[0])


def readings(error_um: float, load: float) -> str:
    """Return Q33 with other contact-angle laws as text, each chain calibrated to the printed ratio."""
    found = {law: single_error_state(error_um, load, screw(law)).load[32] for law in ("exact", "constant")}
    return "; ".join(f"{law} contact angle {value:.2f} N" for law, value in found.items())


def others_change(error_um: float) -> list[float]:
    """Return the smallest and largest load change [N] of the other balls by the error of ball 33, over both loads."""
    change = [np.delete(single_error_state(error_um, f).load - single_error_state(0.0, f).load, 32) for f in (LIGHT, HEAVY)]
    return [float(np.min(change)), float(np.max(change))]


def error_of_load(load: float) -> float:
    """Return the error of ball 33 [um] at which it carries a given load [N] when the axial load is 5000 N."""
    return float(brentq(lambda e: single_error_state(e, HEAVY).load[32] - load, 0.0, 3.0, xtol=1e-6))


def loads_of_others() -> tuple[float, float]:
    """Return the axial loads [N] from which ball 1 and ball 78 carry load, with ball 33 too large by 2 um."""
    errors = one_error(2e-6)
    return (first_carrying_load(screw(), errors, 0, LIGHT), first_carrying_load(screw(), errors, balls() - 1, LIGHT))


def section_4_2(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 4.2."""
    for name, error in (("minus", -2.0), ("plus", 2.0)):
        for load in (LIGHT, HEAVY):
            q = float(single_error_state(error, load).load[32])
            e.number(f"{name}_Q33_{load:.0f}", q, readings(error, load))
            e.number(f"{name}_ratio_{load:.0f}", ratio(error, load))
    q = float(single_error_state(2.0, HEAVY).load[32])
    words = (
        f"142.55 would be {100.0 * (142.55 / q - 1.0):+.2f} % off; 124.55 takes an error of {error_of_load(124.55):.2f} um"
    )
    e.number("plus_Q33_5000", q, words)
    start = first_carrying_load(screw(), one_error(-2e-6), 32, HEAVY)
    e.number("minus_Q33_1000", float(single_error_state(-2.0, LIGHT).load[32]), f"loaded from {start:.0f} N on")
    low, high = others_change(-2.0)
    e.claim("minus_others", low > 0.0, f"by {low:.3f} to {high:.3f} N")
    low, high = others_change(2.0)
    e.claim("plus_others", high < 0.0, f"by {low:.3f} to {high:.3f} N")
    first, last = loads_of_others()
    e.claim("only_33", first > 0.0, f"up to {first:.2f} N; ball 78 carries from {last:.2f} N")
    falls = all(ratio(s, LIGHT) > ratio(s, HEAVY) for s in (-2.0, 2.0))
    e.claim("ratio_falls", falls, ", ".join(f"{ratio(s, LIGHT):.4f} to {ratio(s, HEAVY):.4f}" for s in (-2.0, 2.0)))
    pairs = [(ratio(2.0, f), ratio(-2.0, f)) for f in (LIGHT, HEAVY)]
    words = ", ".join(f"{a:.4f} at +2 um, {b:.4f} at -2 um" for a, b in pairs)
    e.claim("plus_evens", all(a > b for a, b in pairs), words)


RANGES = (1, 2, 3)

NAMES: dict[str, Quantity] = {
    "max": "largest",
    "min": "smallest",
    "loaded": "loaded",
    "unloaded": "loaded",
    "K": "stiffness",
}

#: A step of load over which (22) is compared with its tangent, as a share of the load.
STEP = 0.12

#: Printed sets of +-2 um, each a draw of its own.
SETS = "abc"


def sample_of(key: str) -> Array:
    """Return the sample behind an entry named quantity_range_load, in its printed unit."""
    name, which, load = key.removesuffix("_again").split("_")
    values = drawn_sample(2 if which in SETS else int(which), NAMES[name], float(load))
    if name == "unloaded":
        return balls() - values
    return 1e-8 * values if name == "K" else values


def fewer_given(half_range: int, at_500: int, at_1000: int) -> str:
    """Return a text on the balls loaded at 1000 N in drawn screws that match the printed number at 500 N."""
    first, then = (drawn_sample(half_range, "loaded", f) for f in (500.0, 1000.0))
    some = then[np.abs(first - at_500) <= 1]
    reached = int(np.count_nonzero(some <= at_1000))
    return f"of {some.size} screws with {at_500} ± 1 loaded at 500 N, {reached} have at most {at_1000} at 1000 N"


def record_percentile(e: Findings, key: str, *remarks: str) -> None:
    """Set the computed value of a random number to the median of the draws; note the printed value's percentile."""
    row = next(f.printed for f in e.evidence() if f.printed.key == key)
    values = sample_of(key)
    half = 0.0 if key.startswith(("loaded", "unloaded")) else row.tolerance
    words = place_in(values, e.printed(key), half)[1]
    e.number(key, float(np.median(values)), ". ".join((words, *remarks)))


def likelihood(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[bool, str]:
    """Return whether an event is likely enough, and its probability in words."""
    p = float(np.mean(mask))
    return p >= UNLIKELY, f"probability {p:.3f} ± {np.sqrt(p * (1.0 - p) / mask.size):.3f}"


def falls_with_range(quantity: Quantity, load: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return, for each drawn screw, whether a quantity falls as the error range grows."""
    a, b, c = (drawn_sample(h, quantity, load) for h in RANGES)
    return np.asarray((a > b) & (b > c))


def section_4_3(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 4.3."""
    for row in (f.printed for f in e.evidence()):
        if row.value is not None:
            record_percentile(e, row.key)
    for key, at_500, at_1000 in (
        ("unloaded_2_1000", 53, 62),
        ("unloaded_2_1000_again", 53, 61),
        ("unloaded_3_1000", 42, 43),
    ):
        record_percentile(e, key, fewer_given(int(key.split("_")[1]), at_500, at_1000))
    every = [drawn_sample(h, "loaded", 2137.0) == balls() for h in RANGES]
    holds, words = likelihood(np.logical_and.reduce(every))
    alone = ", ".join(f"{np.mean(m):.3f}" for m in every)
    e.claim("all_2137", holds, f"{words} (singly {alone})")
    e.claim("all_5000", *likelihood(drawn_sample(2, "loaded", 5000.0) == balls()))
    e.claim("fewer", *likelihood(falls_with_range("loaded", 100.0) & falls_with_range("loaded", 500.0)))
    width = {
        (h, f): drawn_sample(h, "largest", f) - drawn_sample(h, "smallest", f) for h in RANGES for f in (1000.0, 5000.0)
    }
    grows = [width[h, 5000.0] > width[h, 1000.0] for h in RANGES]
    grows += [width[h + 1, f] > width[h, f] for h in (1, 2) for f in (1000.0, 5000.0)]
    e.claim("wider", *likelihood(np.logical_and.reduce(grows)))
    a, b, c = (drawn_sample(h, "displacement_first_loaded", 1000.0) for h in RANGES)
    e.claim("further", *likelihood((a < b) & (b < c)))
    _curves(e)


def _curves(e: Findings) -> None:
    """Compute the claims on the curves of displacement over load, by the medians of the drawn screws."""
    loads = np.array(LOADS[1])
    curve = np.array([[np.median(drawn_sample(h, "displacement", f)) for f in loads] for h in RANGES])
    power = np.diff(np.log(curve[1])) / np.diff(np.log(loads))
    words = f"a power between {power.min():.2f} and {power.max():.2f} of the load: it grows ever more slowly"
    e.claim("exponential", bool(power.min() > 1.0), words)
    apart = 1e6 * np.diff(curve, axis=0)
    words = "; ".join(", ".join(f"{v:.2f}" for v in row) for row in apart) + " um from 100 to 5000 N (medians), "
    grown = " and ".join(f"{100.0 * (row[-1] / row[-2] - 1.0):.1f}" for row in apart)
    e.remark("parallel", f"{words}by {grown} % still from 3000 to 5000 N")


def spreads(load: float) -> Array:
    """Return the range [1e8 N/m] of the stiffness within each group of three drawn screws of +-2 um."""
    values = 1e-8 * drawn_sample(2, "stiffness", load)
    return np.asarray(np.ptp(values[: values.size // 3 * 3].reshape(-1, 3), axis=1))


def relative_to_none(key: str, printed: float, reference: float) -> str:
    """Return as text the percentile of a stiffness over the one without errors, free of a common stiffness offset."""
    h, load = int(key.split("_")[1]), float(key.split("_")[2])
    ratio = drawn_sample(h, "stiffness", load) / solve_chain(screw(), np.zeros(balls()), load).stiffness
    return "over the value without errors: " + place_in(ratio, printed / reference, 0.0)[1]


def secant(load: float, step: float) -> float:
    """Return the stiffness (22) without errors [1e8 N/m] at a load by a load step [N]; step 0: the tangent."""
    chain, zero = screw(), np.zeros(balls())
    if step == 0.0:
        return 1e-8 * solve_chain(chain, zero, load).stiffness
    moved = [solve_chain(chain, zero, f).displacement for f in (load, load + step)]
    return 1e-8 * step / (moved[1] - moved[0])


@cache
def secants(half_range_um: int, load: float, share: float) -> Array:
    """Return the secant stiffness of randomly drawn screws over a load step given as a share of the load."""
    if share == 0.0:
        return 1e-8 * drawn_sample(half_range_um, "stiffness", load)
    ends = [load, (1.0 + share) * load]
    found = solve_ensemble(screw(), 1e-6 * half_range_um, ends, MEMBERS, seed=SEED + half_range_um)
    first, last = (found.values_at("displacement", f) for f in ends)
    return np.asarray(1e-8 * share * load / (last - first))


def stiffness_comes_out(row: Printed, share: float) -> bool:
    """Return whether a printed stiffness is within the range of the drawn screws by a given relative load step.

    Without errors: whether it is within 1 % of the computed one, the agreement of the source's other results.
    """
    _, which, load = row.key.split("_")
    assert row.value is not None
    if which == "0":
        return abs(row.value / secant(float(load), share * float(load)) - 1.0) <= 0.01
    values = secants(2 if which in SETS else int(which), float(load), share)
    return bool(values.min() - row.tolerance <= row.value <= values.max() + row.tolerance)


def by_step(rows: Sequence[Printed]) -> str:
    """Return a text on how many printed stiffnesses are reproduced by the tangent, and how many by a load step."""
    counts = [sum(stiffness_comes_out(row, share) for row in rows) for share in (0.0, STEP)]
    return (
        f"the step of load of (22) is not printed: of {len(rows)} stiffnesses {counts[0]} come out with the tangent and "
        f"{counts[1]} by a step of {100.0 * STEP:g} % of the load"
    )


def section_4_4(e: Findings, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the entries of section 4.4."""
    bare, printed_K = e.printed("K_0_3000"), [f.printed for f in e.evidence() if f.printed.key.startswith("K_")]
    for row in printed_K:
        if row.value is not None and row.key != "K_0_3000":
            near = row.key.endswith("_3000")
            record_percentile(e, row.key, *((relative_to_none(row.key, row.value, bare),) if near else ()))
    other = {law: 1e-8 * solve_chain(screw(law), np.zeros(balls()), 3000.0).stiffness for law in ("exact", "constant")}
    words = "; ".join(f"{law} contact angle {value:.3f}" for law, value in other.items())
    words = (
        f"{words}; by a step of {100.0 * STEP:g} % of the load {secant(3000.0, STEP * 3000.0):.3f}; {by_step(printed_K)}"
    )
    e.number("K_0_3000", secant(3000.0, 0.0), words)
    for load in (100, 1100, 2100):
        printed = [e.printed(f"K_{s}_{load}") for s in SETS]
        _, words = place_in(spreads(float(load)), max(printed) - min(printed), 0.0005)
        e.number(f"spread_{load}", max(printed) - min(printed), words.replace("screws", "triples"))
    low = min(e.printed(f"K_{s}_1100") for s in SETS)
    e.number("spread_percent", 100.0 * e.printed("spread_1100") / low)
    _claims(e)


def _claims(e: Findings) -> None:
    """Compute the claims of section 4.4."""
    s = {load: spreads(load) for load in (100.0, 1100.0, 2100.0)}
    e.claim("largest_1100", *likelihood((s[1100.0] > s[100.0]) & (s[1100.0] > s[2100.0])))
    percent = 100.0 * s[100.0] / (1e-8 * np.median(drawn_sample(2, "stiffness", 100.0)))
    median, printed = np.median(percent), 100.0 * e.printed("spread_100") / e.printed("K_a_100")
    e.claim(
        "minimal",
        bool(median <= 4.31),
        f"three draws differ by {median:.0f} % at 100 N in the median; its own by {printed:.1f} %",
    )
    rises = [np.diff(np.stack([drawn_sample(h, "stiffness", f) for f in LOADS[h]]), axis=0) > 0.0 for h in RANGES]
    e.claim(
        "rises", all(bool(r.all()) for r in rises), f"in all of {3 * MEMBERS} drawn screws, {LOADS[1][0]:.0f} to 5000 N"
    )
    e.claim("softer", *likelihood(falls_with_range("stiffness", 500.0)))
    free = solve_chain(screw(), np.zeros(balls()), 3000.0).stiffness
    off = [100.0 * (np.median(drawn_sample(h, "stiffness", 3000.0)) / free - 1.0) for h in RANGES]
    e.remark("meet", ", ".join(f"{x:.1f}" for x in off) + " % in the median of drawn screws")
