"""Sections 3.2, 3.3 and appendix G of Lin's thesis: ball motion and friction in a rotary and a linear bearing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import product
from math import degrees

import numpy as np

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import load_printed_table, printed_entry, printed_value
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.contact import laws
from rollbench.lowfi.friction.linear import chain
from rollbench.lowfi.friction.linear.bearing import Loads, relative_velocity_deviation
from rollbench.lowfi.friction.screw.groove import Mode
from rollbench.lowfi.friction.screw.motion import lin_sigmoid_law
from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Row

#: Inputs of the rotary bearing (Table 3.1) and the linear bearing (Table 3.3).
ROTARY, AXIAL = source_cases.rotary_ball_scene("I").bearing, source_cases.rotary_ball_scene("I").force
_PAIR = source_cases.linear_pair_scene()
LINEAR, VERTICAL, SIDE = _PAIR.bearing, _PAIR.vertical, float(_PAIR.side[0])
THETA, WORST = _PAIR.deviation, source_cases.linear_pair_scene(source_cases.LINEAR_WORST).deviation
#: Radial displacements [m] of cases I to III: not printed, inferred from the forces.
CASES = {name: source_cases.rotary_ball_scene(name).displacement for name in source_cases.ROTARY_SCENES}
#: Slope that Lin prints of the friction force (over its largest value), plotted against the distance of the spin pole from
#: the contact's centre (over the major semi-axis).
K_F = source_cases.printed_friction_slope_over_spin_pole_offset()
#: Lin's sigmoid friction law, with the inferred parameters (sharpness, step of its maps).
_PRINTED = source_cases.rotary_ball_scene("I", printed=True)
PRINTED_LAW = lin_sigmoid_law(ROTARY, _PRINTED.sharpness, _PRINTED.map_step)
#: Ways in which the contact loads of two balls are computed, see `solve_linear_ball_pair`.
LOADS: tuple[Loads, ...] = ("balanced", "diagonal", "elastic")
#: Yield strength [MPa] of appendix G; allowable contact pressure divided by the yield strength.
YIELD, MULTIPLE = 370.0, 4.2


# --- solutions, each computed once


@cache
def rotary_ball_as_printed(case: str) -> bearing.BearingBallSolution:
    """Solve the motion of one ball of the rotary bearing in a case of Lin's Table 3.2 by the method of his thesis.

    Lin's method uses his Hertz constants, his sigmoid friction law, and root finding. ``case``: "I", "II" or "III".
    """
    scene = source_cases.rotary_ball_scene(case, printed=True)
    law = lin_sigmoid_law(scene.bearing, scene.sharpness, scene.map_step)
    return bearing.solve_ball_by_lin_method(scene.bearing, scene.force, scene.displacement, law)


@cache
def solve_rotary_ball(case: str, hertz: Mode = "right") -> bearing.BearingBallSolution:
    """Solve the motion of least friction loss of one ball of the rotary bearing, in a case of Lin's Table 3.2.

    ``case``: "I", "II" or "III"; ``hertz``: "right" for exact Hertz constants, "as printed" for those with Lin's faults,
    which give his loads and contact ellipses.
    """
    return bearing.solve_ball_of_bearing(replace(ROTARY, hertz=hertz), AXIAL, CASES[case])


@cache
def solve_linear_ball_pair(
    theta: float = THETA, loads: Loads = "balanced", mated: bool = False, mu_balls: float = 0.1
) -> chain.LinearPairSolution:
    """Solve the contact of two neighbouring balls in the linear bearing, at the side force of Lin's case study.

    ``theta``: deviation of the contact angle from nominal [rad]; ``loads``: how the contact loads are computed (equal on
    each "diagonal", "balanced" at the stated angles, or "elastic" with angles that follow the loads); ``mated``: whether
    the contact angles of the top groove deviate from nominal as those of the bottom groove do, so that the contacts of each
    diagonal stay opposite (Lin's case (b)), instead of being nominal (case (a)); ``mu_balls``: friction
    coefficient between the balls.
    """
    bearing = replace(LINEAR, mu_balls=mu_balls)
    return chain.solve_pair_of_linear_balls(bearing, theta, SIDE, VERTICAL, mated=mated, loads=loads)


@cache
def ball_force_and_loss_over_grid() -> tuple[Array, Array]:
    """Compute `chain.pair_results_over_grid` of two touching balls in the linear bearing.

    The inputs are the deviation theta of the contact angle from nominal, -3 to 3 deg, and the ratio of side force to
    vertical load, from -0.6 to 0.6.
    """
    theta, rho = np.radians(np.linspace(-3.0, 3.0, 7)), np.linspace(-0.6, 0.6, 7)
    return chain.pair_results_over_grid(LINEAR, theta, rho, VERTICAL, K_F)


# --- computed values for printed numbers


def table_3_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Record the inputs of the rotary bearing in Table 3.1 of Lin's thesis.

    ``findings``: receives the value to compare with each number of the table. ``cache``: not used here.
    """
    findings.numbers(source_cases.groove_inputs(ROTARY))
    findings.numbers({"F_x": AXIAL, "omega_I": ROTARY.screw_speed / (2.0 * np.pi), "E": ROTARY.young})


def value_for_table_3_2(solution: bearing.BearingBallSolution, key: str) -> float:
    """Return the computed value for a row of Lin's Table 3.2, in the unit of the table.

    ``solution``: solved motion of the ball; ``key``: name of the table's row: "F_" (contact load) or "P_" (friction loss)
    followed by the name of a contact or "sum"; "omega_" (angular velocity of the ball) followed by "B" (orbit), "x" or "y";
    or "torque".
    """
    kind, _, what = key.partition("_")
    if kind == "F":
        return float(solution.load.force.sum() if what == "sum" else solution.load.force[bearing.SIDES.index(what)])
    if kind == "P":
        return float(solution.motion.loss if what == "sum" else solution.motion.friction.loss[bearing.SIDES.index(what)])
    if kind == "omega":
        return float(solution.motion.unknown_velocities["Bxy".index(what)])
    return 1e3 * solution.inner_ring_torque


def increase_between_cases(first: bearing.BearingBallSolution, raised: bearing.BearingBallSolution, quantity: str) -> float:
    """Return the increase of a quantity between two cases of the rotary bearing.

    ``first``, ``raised``: solved motions of the ball in the cases with the smaller and the larger value; ``quantity``:
    "force": increase of the sum of the contact forces [%]; any other text: increase of the friction torque, divided by its
    smaller value.
    """
    if quantity == "force":
        return float(error_percent(raised.load.force.sum(), first.load.force.sum()))
    return raised.inner_ring_torque / first.inner_ring_torque - 1.0


#: Name of the 3D model's result and factor to the table's unit, by key of Table 3.2.
IN_3D = {f"P_{side}": (f"loss {side} mW", 1e-3) for side in bearing.SIDES} | {"torque": ("torque N mm", 1.0)}
IN_3D |= {f"omega_{axis}": (f"{name} rad/s", 1.0) for axis, name in (("B", "orbit"), ("x", "omega x"), ("y", "omega y"))}


def table_3_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute contact forces, losses and ball motion of the rotary bearing: Table 3.2 and section 3.2.2 of Lin's thesis.

    ``findings``: receives two values to compare with each printed number: as printed, with Lin's faults, and correct, with
    exact Hertz constants and least dissipation; ``cache``: gives stored results of the 3D rolling model.
    """
    solid = {case: source_cases.stored_3d_results(cache, name) for case, name in source_cases.ROTARY_SCENES.items()}
    for row in load_printed_table("lin-3.2"):
        key, _, case = row.key.rpartition("_")
        solve = rotary_ball_as_printed, solve_rotary_ball
        if key.endswith("_increase"):
            what = key.removesuffix("_increase")
            faulty, true = (increase_between_cases(f("I"), f(case), what) for f in solve)
        else:
            faulty, true = (value_for_table_3_2(f(case), key) for f in solve)
        words = f"as printed, the computed forces add to {faulty:.4f} N" if row.entry_class == "open" else ""
        name, unit = IN_3D.get(key, ("", 1.0))
        value = solid[case].get(name)
        if key == "P_sum":
            unit, value = 1e-3, sum(v for what, v in solid[case].items() if what.startswith("loss ")) or None
        findings.add_number(row.key, true, words, as_printed=faulty, reference=None if value is None else unit * value)


def table_3_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute inputs and largest friction of the linear bearing, and check claims: Lin's Table 3.3 and section 3.3.4.1.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    b = LINEAR
    values = {
        "ball_radius": 1e3 * b.ball_radius,
        "conformity": b.conformity,
        "psi": b.semi_axis_constant(),
        "vertical": VERTICAL,
        "speed": 1e3 * b.speed,
        "mu": b.mu,
        "young": b.young,
        "poisson": b.poisson,
        "contact_angle": degrees(b.contact_angle),
    }
    findings.numbers(values)
    findings.follow({"yaw": abs(SIDE) * VERTICAL * 2e3 * b.ball_radius})
    _record_largest_friction_loss_increase(findings)
    _check_claims_on_force_and_loss_grid(findings, ball_force_and_loss_over_grid())


def _record_largest_friction_loss_increase(findings: ComputedEntryValues) -> None:
    """Compute the largest increase of friction loss in Lin's section 3.3.4.1; ``findings`` receives the results.

    The increase is the friction loss between two touching balls, divided by the loss of both balls without ball-to-ball
    contact.
    """
    worst = solve_linear_ball_pair(WORST)
    whole = float(error_percent(worst.touching.loss, worst.apart.loss))
    ratio = worst.groove_and_ball_loss_ratio
    words = f"Ours is the loss between the balls over the baseline; with the change of the groove losses {whole:.1f} %"
    findings.add_number("worst_ratio", float(error_percent(ratio, 1.0)), words, as_printed=100.0 * ratio)


def _check_claims_on_force_and_loss_grid(findings: ComputedEntryValues, maps: tuple[Array, Array]) -> None:
    """Check Lin's claims on ball-to-ball force and losses of two balls over contact-angle deviation and side force.

    ``maps``: these quantities by the numerical model and by Lin's formulas. ``findings``: receives the results.
    """
    numerical, formula = maps
    difference, force, ratio = numerical
    fields = (force[4:, 2::-1], ratio[4:, 2::-1])
    grows = all(bool(np.all(np.diff(f, axis=axis) > 0.0)) for f in fields for axis in (0, 1))
    top = float(error_percent(ratio.max(), 1.0))
    findings.add_claim("worst_increase", grows and top > 50.0, f"grows along both axes, up to {top:.0f} %")
    pairs = list(zip((difference, force, ratio - 1.0), formula - numerical, strict=True))
    inside = max(float(np.abs(e[2:5, 2:5]).max() / np.abs(v).max()) for v, e in pairs)
    corner = min(float(np.abs(e).max() / np.abs(v).max()) for v, e in pairs)
    words = (
        f"error of the formulas over the largest value: at most {inside:.1%} within half of both ranges, "
        f"at least {corner:.1%} at the corners"
    )
    findings.add_claim("maps_agree", inside < 0.02 and corner > 3.0 * inside, words)
    closing = difference > 1e-9
    apart = float(np.abs(force[~closing]).max())
    words = f"{int(closing.sum())} of {closing.size} points close in, each with a force; elsewhere {apart:.0e} N"
    findings.add_claim("sign_region", bool(np.all(force[closing] > 0.0)) and apart < 1e-8, words)


def velocity_deviations_by_formula(mated: bool) -> Array:
    """Return the relative deviations (2,) of two balls' velocities from nominal by Lin's formula (3.43).

    The contact loads are those that Lin states in the text: equal at both contacts of each diagonal. ``mated``: whether
    the contact angles of the top groove deviate, too (case (b)), instead of being nominal (case (a)).
    """
    angles, loads = chain.pair_angles_and_loads(LINEAR, THETA, SIDE, VERTICAL, mated=mated, loads="diagonal")
    return relative_velocity_deviation(LINEAR.contact_angle, angles - LINEAR.contact_angle, loads[:, 0], loads[:, 1])


def table_3_4(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the velocity deviations [%] of two balls in the linear bearing: Table 3.4 of Lin's thesis.

    ``findings``: receives the computed value to compare with each number of the table; ``cache``: gives stored results of
    the 3D rolling model.
    """
    findings.numbers({"theta": degrees(THETA), "rho": SIDE})
    for case, name in (("a", source_cases.LINEAR_PAIR), ("b", source_cases.LINEAR_MATED)):
        scene = source_cases.linear_pair_scene(name)
        top = (scene.angles[0, 2:] - scene.bearing.contact_angle) / scene.deviation  # at TR and TL
        findings.numbers({f"{case}_TR": float(top[0]), f"{case}_TL": float(top[1])})
    for case, ball in product("ab", (1, 2)):
        mated = case == "b"
        found, formula = solve_linear_ball_pair(mated=mated).velocity_deviation, velocity_deviations_by_formula(mated)
        solid = source_cases.stored_3d_results(cache, f"lin-pair-{case}").get(f"deviation {ball} apart %")
        findings.add_number(f"{case}_eps{ball}_numerical", 100.0 * float(found[ball - 1]), reference=solid)
        findings.add_number(f"{case}_eps{ball}_analytic", 100.0 * float(formula[ball - 1]), reference=solid)


def ball_force_with_misprinted_exponents() -> float:
    """Return the ball-to-ball force in the linear bearing by Lin's formula (3.51) with its misprinted exponents -2/3.

    The force is that of case (a), in which the contact angles of the top groove are nominal. With these exponents the
    result has no unit of force; the loads are inserted in N.
    """
    loads = chain.pair_angles_and_loads(LINEAR, THETA, SIDE, VERTICAL, loads="diagonal")[1][:, :2]
    right_way, as_is = (np.cbrt(loads) ** power for power in (2.0, -2.0))
    joined = [float(s[0].sum() * s[1].sum() / s.sum()) for s in (right_way, as_is)]
    return chain.pair_results_by_formulas(LINEAR, THETA, SIDE, VERTICAL, K_F)[1] * joined[1] / joined[0]


def formula_force(*, mated: bool) -> float:
    """Return the ball-to-ball force [N] in the linear bearing by Lin's formula (3.51).

    ``mated``: whether the contact angles of the top groove deviate from nominal, too (case (b)), or are nominal (case (a)).
    """
    return chain.pair_results_by_formulas(LINEAR, THETA, SIDE, VERTICAL, K_F, mated=mated)[1]


def table_3_5(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute ball-to-ball forces [N] of the linear bearing and differences from ANSYS: Table 3.5 of Lin's thesis.

    ``findings``: receives the computed value to compare with each number of the table; ``cache``: gives stored results of
    the 3D rolling model.
    """
    spread = ", ".join(f"{loads} {solve_linear_ball_pair(loads=loads).ball_to_ball_force:.2f} N" for loads in LOADS)
    formula = {case: formula_force(mated=case == "b") for case in "ab"}
    solid = {case: source_cases.stored_3d_results(cache, f"lin-pair-{case}").get("force 1-2 N") for case in "ab"}
    as_is = f"with the exponents -2/3 as printed the formula gives {ball_force_with_misprinted_exponents():.2g} N"
    for case, of_loads, of_formula in (("a", f"loads {spread}", as_is), ("b", "", "")):
        numerical = solve_linear_ball_pair(mated=case == "b").ball_to_ball_force
        findings.add_number(f"{case}_force_numerical", numerical, of_loads, reference=solid[case])
        findings.add_number(f"{case}_force_ansys", None, reference=solid[case])
        findings.add_number(f"{case}_force_analytic", formula[case], of_formula, reference=solid[case])
    ansys = printed_value("lin-3.5", "a_force_ansys")
    for name, ours in (("numerical", solve_linear_ball_pair().ball_to_ball_force), ("analytic", formula["a"])):
        off = [f"{error_percent(ours, other):+.1f} %" for other in (ansys, solid["a"]) if other is not None]
        words = f"computed here: {off[0]} off the printed ANSYS force" + "".join(f", {x} off the 3D force" for x in off[1:])
        follows = abs(float(error_percent(printed_value("lin-3.5", f"a_force_{name}"), ansys)))
        findings.add_number(f"error_{name}", None, words, follows=follows)
    for model, case in product(("numerical", "analytic", "ansys"), "ab"):
        findings.add_remark(f"{case}_time_{model}", "another machine and language; not compared")


def contact_ellipse_ratios(conformity: float, pressure: float) -> tuple[float, float]:
    """Return the proportions of the contact ellipse of a ball in a straight groove.

    First: ratio b/a of the minor to the major semi-axis; second: major semi-axis a divided by the ball's radius, at the
    largest Hertz pressure ``pressure`` [Pa]. ``conformity``: groove radius over ball diameter.
    """
    modulus = contact_modulus(*2 * (LINEAR.young, LINEAR.poisson))
    h = hertz_constants(np.array(1.0), np.array(1.0 - 0.5 / conformity), modulus)
    return float(h.C_b / h.C_a), float(h.C_a) * pressure * np.pi * float(h.C_a * h.C_b) / 1.5


def appendix_g(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute slope and linear range of the friction force against the offset of the spin pole: appendix G of Lin's thesis.

    ``findings``: receives the computed value to compare with each printed number. ``cache``: not used here.
    """
    pressure = MULTIPLE * YIELD
    ratio = contact_ellipse_ratios(LINEAR.conformity, 1e6 * pressure)[0]
    slope, cubic = float(laws.linear_friction_force_factor(ratio)), float(laws.cubic_friction_force_factor(ratio))
    a_over_r = contact_ellipse_ratios(0.52, 1e6 * pressure)[1]
    reach, cut = printed_value("lin-G", "reach"), np.floor(1e3 * a_over_r) / 1e3
    off = 100.0 * float(laws.error_of_linear_friction_force(ratio, K_F))
    words = (
        f"exact slope at c = 0 for conformity {LINEAR.conformity}; secant to c/a = 0.5 {slope - 0.25 * cubic:.3f}; the "
        f"printed slope is off by up to {off:.1f} % of the force"
    )
    findings.add_number("k_f", slope, words)
    findings.add_remark("reach", f"a choice: the cubic term is {0.25 * cubic / slope:.1%} of the linear one there")
    findings.follow({"pressure": pressure})
    findings.add_number("a_over_R", a_over_r, "the printed digits are those of the exact value, cut off", as_printed=cut)
    eta = degrees(reach * a_over_r)
    findings.add_number("eta", eta, "from the value that was cut off", as_printed=degrees(reach * cut))


# --- sections 3.2 and 3.3 under several assumptions: balance of power in the rotary bearing, loads of the linear bearing


def power_balance_rows() -> Iterator[Row]:
    """Yield table rows of the rotary bearing's friction torque [N mm], power input [W] and friction losses [W].

    There are three rows for each case of Lin's Table 3.2: correct Hertz constants and Coulomb friction; Coulomb friction at
    the contact loads that Lin computed; and all as Lin computed it. The motion of the first two minimises the dissipation.
    """
    for case in CASES:
        for label, s in (
            ("right", solve_rotary_ball(case)),
            ("least dissipation at the loads as printed", solve_rotary_ball(case, "as printed")),
            ("as printed", rotary_ball_as_printed(case)),
        ):
            torque = bearing.inner_ring_torque(ROTARY, s.load, s.motion)
            power = torque * ROTARY.screw_speed
            balance = float(error_percent(power, s.motion.loss))
            yield {
                "case_of_table_3_2": case,
                "friction_model": label,
                "normal_force_sum": float(s.load.force.sum()),
                "inner_ring_torque": 1e3 * torque,
                "power_input": power,
                "friction_loss": s.motion.loss,
                "power_balance": balance,
                "sticking_contacts": int(s.motion.sticking_contacts.sum()),
                "status": s.motion.status,
            }


def linear_pair_sensitivity_rows() -> Iterator[Row]:
    """Yield table rows of ball-to-ball force and friction losses in the linear bearing, one for each pair of assumptions.

    The first assumption is how the contact loads of the two balls are computed, the second is the friction coefficient
    between the balls.
    """
    printed = printed_entry("lin-3.5", "a_force_numerical")
    for loads, mu in product(LOADS, (0.1, 0.0)):
        r, worst = solve_linear_ball_pair(loads=loads, mu_balls=mu), solve_linear_ball_pair(WORST, loads, mu_balls=mu)
        eps = [100.0 * float(x) for x in r.velocity_deviation]
        force_error = float(error_percent(r.ball_to_ball_force, printed.value or 0.0))
        yield {
            "load_method": loads,
            "ball_friction": mu,
            "eps1": eps[0],
            "eps2": eps[1],
            ("ball_force_at", "2"): r.ball_to_ball_force,
            ("ball_force_error", printed.number_as_printed): force_error,
            "loss_ratio_3_deg": 100.0 * worst.groove_and_ball_loss_ratio,
            ("loss_increase_at", "3"): float(error_percent(worst.touching.loss, worst.apart.loss)),
            "status": "converged" if r.touching.converged else "not converged",
        }
