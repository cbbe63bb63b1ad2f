"""Liu, sections 2, 3, 4.1 and 4.2: inputs, the algorithm, the experiment, Mei's model, one ball too small or too large."""

from __future__ import annotations

from dataclasses import replace
from math import cos, degrees, sin

import numpy as np

from rollbench.compare.cases.liu.evidence import case
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.models.study import Study
from rollbench.lowfi.random_errors.chain import Chain, end_ratio, first_carrying_load, solve_chain
from rollbench.lowfi.random_errors.elimination import solve_by_elimination
from rollbench.lowfi.random_errors.ensemble import draw_errors
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.roots import brentq

#: Drawn screws on which the two algorithms are compared, or that are solved one by one.
FEW = 20
#: Loads [N] under which a ball is off by 2 um.
LIGHT, HEAVY = 1000.0, 5000.0


def section_2(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 2.1 and Table 2."""
    scene = case.liu_screw()
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
    e.numbers({f"e_{h}": float(h) for h in case.LOADS})
    e.claim("plus_or_minus", False, "the plus sign draws in [e, 3 e], the minus sign in [-e, e]")


def loosest_agreement() -> tuple[int, int, float]:
    """Of ``FEW`` screws of +-2 um at 500 N: those with the same active set by both algorithms; most rounds of the
    elimination; largest difference of a load over the largest load."""
    errors = draw_errors(case.SEED, 0, FEW, case.balls(), 2e-6)
    same, rounds, worst = 0, 0, 0.0
    for e in errors:
        ours, other = solve_chain(case.screw(), e, 500.0), solve_by_elimination(case.screw(), e, 500.0)
        same += int(other.converged and np.array_equal(ours.load > 0.0, other.load > 0.0))
        rounds = max(rounds, other.rounds)
        worst = max(worst, float(np.abs(ours.load - other.load).max() / ours.load.max()))
    return same, rounds, worst


def section_3(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 3."""
    steps = max(solve_chain(case.screw(), x, 500.0).iterations for x in draw_errors(case.SEED, 0, FEW, case.balls(), 2e-6))
    same, rounds, worst = loosest_agreement()
    e.claim(
        "newton",
        False,
        f"on the convex energy at most {steps} steps for {FEW} screws at 500 N; the elimination's loaded balls are "
        f"the same in {same} of {FEW}, in up to {rounds} rounds, loads to {worst:.0e}",
    )
    loaded = {f: case.sample(2, "loaded", f) for f in (500.0, 1000.0, 1500.0, 2000.0)}
    share = float(np.mean(loaded[2000.0] == case.balls()))
    e.claim("all_2000", share >= case.UNLIKELY, f"probability {share:.3f}")
    for key, load in (("unloaded_1500", 1500.0), ("unloaded_500", 500.0)):
        sample = case.balls() - loaded[load]
        e.number(key, float(np.median(sample)), case.place_in(sample, e.printed(key), 0.0)[1])
    exactly = {f: float(np.mean(loaded[f] == case.balls() - 1)) for f in (1000.0, 1500.0)}
    e.words("caption_1000", "probability of exactly one: {:.3f} at 1000 N, {:.3f} at 1500 N".format(*exactly.values()))
    e.numbers({"load": e.printed("load"), "free_length": e.printed("free_length")})
    ratio = case.sample(3, "smallest", 3000.0) / case.sample(3, "largest", 3000.0)
    low, high = np.quantile(ratio, [case.UNLIKELY, 1.0 - case.UNLIKELY])
    e.claim("uniform_3000", low > 0.5, f"smallest over largest load {low:.2f} to {high:.2f} (central 99 %) at 3000 N")
    medians = [float(np.median(case.sample(3, "stiffness", f))) / 1e8 for f in case.LOADS[3]]
    words = ", ".join(f"{v:.2f}" for v in medians)
    e.claim("falls", bool(np.all(np.diff(medians) < 0.0)), f"{words} 1e8 N/m from 100 to 5000 N (medians, ±3 um)")


def mei() -> Chain:
    """Mei's model as the source uses it: 45 deg, the compliance of the source's own model."""
    return replace(case.screw(), law="constant")


def mei_deviations(chain: Chain, errors: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[float, float]:
    """Largest deviation of a chain's loads from Mei's at 5000 N [%], over Mei's load and over the chain's."""
    load = solve_chain(chain, errors, case.calibration_load()).load
    mei = solve_chain(replace(chain, law="constant"), errors, case.calibration_load()).load
    return float(100.0 * np.abs(1.0 - load / mei).max()), float(100.0 * np.abs(mei / load - 1.0).max())


def section_4_1(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 4.1."""
    load = case.calibration_load()
    area = 1e6 * case.implied_area(26.0)
    words = f"compliance of a segment {case.screw().compliance:.4g} m/N"
    words += f": with 26 balls a turn, areas in series 1/(1/A_n + 1/A_s) = {area:.0f} mm2"
    e.number("ratio", end_ratio(case.screw(), load), words)
    exact = end_ratio(replace(case.screw("exact"), law="constant"), load)
    e.number("ratio_mei", end_ratio(mei(), load), f"beside the exact contact angle it would be {exact:.4f}")
    zero = np.zeros(case.balls())
    found = [x for law in ("implicit", "exact") for x in mei_deviations(case.screw(law), zero)]
    e.number("deviation", found[0], "implicit {:.2f} of Mei's, {:.2f} of its own load; exact {:.2f}, {:.2f}".format(*found))
    less = solve_chain(mei(), zero, load).load - case.single(0.0, load).load
    e.claim("smaller", bool(np.all(less > 0.0)), f"by {less.min():.2f} to {less.max():.2f} N")
    errors = draw_errors(case.SEED, 0, FEW, case.balls(), 2e-6)
    worst = [mei_deviations(case.screw(), x)[0] for x in errors]
    e.claim("deviation_errors", max(worst) <= 2.875, f"{min(worst):.2f} to {max(worst):.2f} % in {FEW} drawn screws")


def ratio(error_um: float, load: float) -> float:
    """Q78/Q1."""
    q = case.single(error_um, load).load
    return float(q[-1] / q[0])


def readings(error_um: float, load: float) -> str:
    """Q33 by the other contact angles, each calibrated in the same way."""
    found = {law: case.single(error_um, load, case.screw(law)).load[32] for law in ("exact", "constant")}
    return "; ".join(f"{law} contact angle {value:.2f} N" for law, value in found.items())


def others_change(error_um: float) -> list[float]:
    """Smallest and largest change of another ball's load against that without the error, over both loads [N]."""
    change = [np.delete(case.single(error_um, f).load - case.single(0.0, f).load, 32) for f in (LIGHT, HEAVY)]
    return [float(np.min(change)), float(np.max(change))]


def error_of_load(load: float) -> float:
    """Error of ball 33 [um] with which it carries the load [N] at 5000 N."""
    return float(brentq(lambda e: case.single(e, HEAVY).load[32] - load, 0.0, 3.0, xtol=1e-6))


def loads_of_others() -> tuple[float, float]:
    """Loads [N] from which another ball than 33 carries, and all do, at +2 um."""
    errors = case.one_error(2e-6)
    return (
        first_carrying_load(case.screw(), errors, 0, LIGHT),
        first_carrying_load(case.screw(), errors, case.balls() - 1, LIGHT),
    )


def section_4_2(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Section 4.2."""
    for name, error in (("minus", -2.0), ("plus", 2.0)):
        for load in (LIGHT, HEAVY):
            q = float(case.single(error, load).load[32])
            e.number(f"{name}_Q33_{load:.0f}", q, readings(error, load))
            e.number(f"{name}_ratio_{load:.0f}", ratio(error, load))
    q = float(case.single(2.0, HEAVY).load[32])
    words = (
        f"142.55 would be {100.0 * (142.55 / q - 1.0):+.2f} % off; 124.55 takes an error of {error_of_load(124.55):.2f} um"
    )
    e.number("plus_Q33_5000", q, words)
    start = first_carrying_load(case.screw(), case.one_error(-2e-6), 32, HEAVY)
    e.number("minus_Q33_1000", float(case.single(-2.0, LIGHT).load[32]), f"loaded from {start:.0f} N on")
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
