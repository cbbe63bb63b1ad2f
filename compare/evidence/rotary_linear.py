"""Lin 3.2 and 3.3: our values of every printed number, and the findings; each solution is made once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from math import degrees

import numpy as np

from compare.evidence import source_cases
from compare.measure import error_percent
from compare.models.study import Study
from compare.printed.findings import Finding, collect, entry
from compare.printed.printed_data import load_table
from lowfi.friction.bearing.rotary import SIDES, Mode, Solution, solve_ball, solve_ball_as_printed, source_law
from lowfi.friction.contact.ellipse import Array, cubic_factor, linear_error, linear_factor
from lowfi.friction.linear.analytic import velocity_deviation
from lowfi.friction.linear.loads import Loads
from lowfi.friction.linear.pair import PairMaps, PairResult, maps, pair_formulas, pair_state, solve_pair
from lowfi.hertz import contact_modulus, hertz_constants

TABLES = ("lin-3.1", "lin-3.2", "lin-3.3", "lin-3.4", "lin-3.5", "lin-G")
#: Tables 3.1 and 3.3: inputs of the two case studies.
ROTARY, AXIAL = source_cases.rotary("I").bearing, source_cases.rotary("I").force
LINEAR, VERTICAL, SIDE = source_cases.linear().bearing, source_cases.linear().vertical, float(source_cases.linear().side[0])
THETA, WORST = source_cases.linear().deviation, source_cases.linear(source_cases.LINEAR_WORST).deviation
#: Radial displacements [m] of cases I to III: not printed, inferred from the forces.
CASES = {name: source_cases.rotary(name).displacement for name in source_cases.ROTARY_SCENES}
#: Slope of the normalised friction force, as printed.
K_F = source_cases.k_f()
#: The source's own law of friction, with what was inferred for it.
PRINTED_LAW = source_law(
    ROTARY, source_cases.rotary("I", printed=True).sharpness, source_cases.rotary("I", printed=True).map_step
)
LOADS: tuple[Loads, ...] = ("balanced", "diagonal", "elastic")
#: Yield strength [MPa] and its multiple that make the allowable pressure of appendix G.
YIELD, MULTIPLE = 370.0, 4.2


@dataclass(frozen=True)
class Ours:
    """Our values of a printed entry in its unit: faults repeated, right; for a claim whether it holds; evidence."""

    as_printed: float | None = None
    right: float | None = None
    holds: bool | None = None
    evidence: str = ""


# --- solutions, each made once


@cache
def as_printed(case: str) -> Solution:
    """A case of Table 3.2 with the source's Hertz constants, sigmoid and root."""
    scene = source_cases.rotary(case, printed=True)
    law = source_law(scene.bearing, scene.sharpness, scene.map_step)
    return solve_ball_as_printed(scene.bearing, scene.force, scene.displacement, law, fast=True)


@cache
def right(case: str, hertz: Mode = "right") -> Solution:
    """The same with least dissipation; hertz "as printed" keeps the source's loads and ellipses."""
    return solve_ball(ROTARY, AXIAL, CASES[case], hertz, fast=True)


@cache
def pair(theta: float = THETA, loads: Loads = "balanced", mated: bool = False, mu_balls: float = 0.1) -> PairResult:
    """The linear pair at the side force ratio of the case study."""
    return solve_pair(replace(LINEAR, mu_balls=mu_balls), theta, SIDE, VERTICAL, mated=mated, loads=loads)


@cache
def claim_maps() -> PairMaps:
    """Coarse maps that the claims are held against: theta from -3 to 3 deg, rho from -0.6 to 0.6."""
    return maps(LINEAR, np.radians(np.linspace(-3.0, 3.0, 7)), np.linspace(-0.6, 0.6, 7), VERTICAL, K_F)


# --- values of the printed entries


def given_rotary() -> dict[str, Ours]:
    """Table 3.1: inputs."""
    b = ROTARY
    values = {
        "R_B": 1e3 * b.ball_radius,
        "conformity": 0.5 * b.groove_radius / b.ball_radius,
        "R_P": 1e3 * b.pitch_radius,
        "beta": degrees(b.contact_angle),
        "F_x": AXIAL,
        "omega_I": b.speed / (2.0 * np.pi),
        "mu": b.mu,
        "E": b.young,
        "nu": b.poisson,
    }
    return {key: Ours(right=float(v)) for key, v in values.items()}


def rotary_value(s: Solution, key: str) -> float:
    """Quantity of a row of Table 3.2 (the key without its case) in the unit printed there."""
    kind, _, what = key.partition("_")
    if kind == "F":
        return float(s.load.force.sum() if what == "sum" else s.load.force[SIDES.index(what)])
    if kind == "P":
        return float(s.motion.loss if what == "sum" else s.motion.friction.loss[SIDES.index(what)])
    if kind == "omega":
        return float(s.motion.q["Bxy".index(what)])
    return 1e3 * s.torque


def rise(first: Solution, now: Solution, what: str) -> float:
    """Increase of the sum of forces [%], or of the torque in torques of the first."""
    if what == "force":
        return float(error_percent(now.load.force.sum(), first.load.force.sum()))
    return now.torque / first.torque - 1.0


def table_3_2() -> dict[str, Ours]:
    """Table 3.2 and the increases of 3.2.2: as printed beside exact Hertz constants and least dissipation."""
    out = {}
    for row in load_table("lin-3.2"):
        key, _, case = row.key.rpartition("_")
        if key.endswith("_increase"):
            what = key.removesuffix("_increase")
            two = rise(as_printed("I"), as_printed(case), what), rise(right("I"), right(case), what)
            out[row.key] = Ours(*two)
            continue
        faulty, true = rotary_value(as_printed(case), key), rotary_value(right(case), key)
        words = f"ours as printed adds to {faulty:.4f} N" if row.cls == "open" else ""
        out[row.key] = Ours(faulty, true, evidence=words)
    return out


def table_3_3() -> dict[str, Ours]:
    """Table 3.3: inputs, the worst case of 3.3.4.1 and its claims."""
    b, worst, m = LINEAR, pair(WORST), claim_maps()
    values = {
        "ball_radius": 1e3 * b.ball_radius,
        "conformity": b.conformity,
        "psi": b.psi(),
        "vertical": VERTICAL,
        "speed": 1e3 * b.speed,
        "mu": b.mu,
        "young": b.young,
        "poisson": b.poisson,
        "contact_angle": degrees(b.contact_angle),
        "yaw": abs(SIDE) * VERTICAL * 2e3 * b.ball_radius,
    }
    out = {key: Ours(right=v) for key, v in values.items()}
    total = 100.0 * worst.touching.loss / worst.free.loss
    added = float(error_percent(worst.rubbing_ratio, 1.0))
    out["worst_ratio"] = Ours(
        100.0 * worst.rubbing_ratio,
        total,
        evidence=f"an increase of {added:.1f} %, of {float(error_percent(total, 100.0)):.1f} % with the groove losses' "
        "change, which the right value counts",
    )
    fields = (m.force[4:, 2::-1], m.ratio[4:, 2::-1])
    grows = all(bool(np.all(np.diff(f, axis=axis) > 0.0)) for f in fields for axis in (0, 1))
    top = float(error_percent(m.ratio.max(), 1.0))
    out["worst_increase"] = Ours(holds=grows and top > 50.0, evidence=f"grows along both axes, up to {top:.0f} %")
    pairs = ((m.difference, m.difference_error), (m.force, m.force_error), (m.ratio - 1.0, m.ratio_error))
    inside = max(float(np.abs(e[2:5, 2:5]).max() / np.abs(v).max()) for v, e in pairs)
    corner = min(float(np.abs(e).max() / np.abs(v).max()) for v, e in pairs)
    out["maps_agree"] = Ours(
        holds=inside < 0.02 and corner > 3.0 * inside,
        evidence=f"error of the formulas over the largest value: at most {inside:.1%} within half of both ranges, "
        f"at least {corner:.1%} at the corners",
    )
    closing = m.difference > 1e-9
    apart = float(np.abs(m.force[~closing]).max())
    out["sign_region"] = Ours(
        holds=bool(np.all(m.force[closing] > 0.0)) and apart < 1e-8,
        evidence=f"{int(closing.sum())} of {closing.size} points close in, each with a force; elsewhere {apart:.0e} N",
    )
    return out


def formula_deviation(mated: bool) -> Array:
    """Deviations (2,) of both balls by (3.43) at the loads of the text."""
    angles, loads = pair_state(LINEAR, THETA, SIDE, VERTICAL, mated=mated, loads="diagonal")
    return velocity_deviation(LINEAR.contact_angle, angles - LINEAR.contact_angle, loads[:, 0], loads[:, 1])


def table_3_4() -> dict[str, Ours]:
    """Table 3.4: velocity deviations [%]."""
    out = {}
    for case, ball in product("ab", (1, 2)):
        found, formula = pair(mated=case == "b").free.deviation, formula_deviation(case == "b")
        of_text = pair(loads="diagonal", mated=case == "b").free.deviation  # the text: equal loads on each diagonal
        as_printed_, right_ = (100.0 * float(d[ball - 1]) for d in (found, of_text))
        out[f"{case}_eps{ball}_numerical"] = Ours(as_printed_, right_) if case == "a" else Ours(right=as_printed_)
        out[f"{case}_eps{ball}_analytic"] = Ours(right=100.0 * float(formula[ball - 1]))
    return out


def misprinted_force() -> float:
    """(3.51) for case (a) with its exponents -2/3 [N if its dimensions held]."""
    loads = pair_state(LINEAR, THETA, SIDE, VERTICAL, loads="diagonal")[1][:, :2]
    right_way, as_is = (np.cbrt(loads) ** power for power in (2.0, -2.0))
    both = [float(s[0].sum() * s[1].sum() / s.sum()) for s in (right_way, as_is)]
    return pair_formulas(LINEAR, THETA, SIDE, VERTICAL, K_F)[1] * both[1] / both[0]


def table_3_5() -> dict[str, Ours]:
    """Table 3.5: ball-to-ball forces [N] and the differences from ANSYS; times stay open."""
    printed = {r.key: r.value or 0.0 for r in load_table("lin-3.5")}
    spread = ", ".join(f"{loads} {pair(loads=loads).force:.2f} N" for loads in LOADS)
    out = {}
    for case in "ab":
        mated = case == "b"
        out[f"{case}_force_numerical"] = Ours(right=pair(mated=mated).force, evidence=f"loads {spread}" * (not mated))
        out[f"{case}_force_analytic"] = Ours(right=pair_formulas(LINEAR, THETA, SIDE, VERTICAL, K_F, mated=mated)[1])
    inverse = misprinted_force()
    words = f"with the exponents -2/3 as printed the formula gives {inverse:.2g} N"
    out["a_force_analytic"] = replace(out["a_force_analytic"], evidence=words)
    ansys = printed["a_force_ansys"]
    off = abs(float(error_percent(out["a_force_analytic"].right or 0.0, ansys)))
    out["error_numerical"] = Ours(right=float(error_percent(printed["a_force_numerical"], ansys)))
    out["error_analytic"] = Ours(holds=off < 6.0, evidence=f"{off:.1f} % off the printed ANSYS force")
    for model in ("numerical", "analytic", "ansys"):
        for case in "ab":
            words = "another machine and language; not compared, see table timing-friction"
            out[f"{case}_time_{model}"] = Ours(evidence=words)
    return out


def straight_groove(conformity: float, pressure: float) -> tuple[float, float]:
    """Ratio b/a, and a over the ball's radius at the Hertz pressure [Pa], of a ball in a straight groove."""
    h = hertz_constants(
        np.array(1.0), np.array(1.0 - 0.5 / conformity), contact_modulus(*2 * (LINEAR.young, LINEAR.poisson))
    )
    return float(h.C_b / h.C_a), float(h.C_a) * pressure * np.pi * float(h.C_a * h.C_b) / 1.5


def appendix_g() -> dict[str, Ours]:
    """Appendix G: the linear range of the friction force, for the groove of Table 3.3 and conformity 0.52."""
    pressure = MULTIPLE * YIELD
    ratio = straight_groove(LINEAR.conformity, 1e6 * pressure)[0]
    slope, cubic = float(linear_factor(ratio)), float(cubic_factor(ratio))
    a_over_r = straight_groove(0.52, 1e6 * pressure)[1]
    reach, cut = entry("lin-G", "reach").value or 0.0, np.floor(1e3 * a_over_r) / 1e3
    off = 100.0 * float(linear_error(ratio, K_F))
    return {
        "k_f": Ours(
            right=slope,
            evidence=f"exact slope at c = 0 for conformity {LINEAR.conformity}; secant to c/a = 0.5 "
            f"{slope - 0.25 * cubic:.3f}; the printed slope is off by up to {off:.1f} % of the force",
        ),
        "reach": Ours(evidence=f"a choice: the cubic term is {0.25 * cubic / slope:.1%} of the linear one there"),
        "pressure": Ours(right=pressure),
        "a_over_R": Ours(cut, a_over_r, evidence="the printed digits are those of the exact value, cut off"),
        "eta": Ours(degrees(reach * cut), degrees(reach * a_over_r), evidence="from the value that was cut off"),
    }


@cache
def ours() -> dict[str, dict[str, Ours]]:
    """Our values of all tables."""
    made = (given_rotary(), table_3_2(), table_3_3(), table_3_4(), table_3_5(), appendix_g())
    return dict(zip(TABLES, made, strict=True))


def findings(study: Study) -> list[Finding]:
    """Every printed entry of 3.2, 3.3 and appendix G; the study notes the scenes."""
    study.uses(source_cases.SCENES_3_2_3_3)
    out = []
    for table, values in ours().items():
        found = {key: Finding(entry(table, key), v.right, v.as_printed, v.holds, v.evidence) for key, v in values.items()}
        out += collect(table, found)
    return out


def numbers(values: Array, factor: float = 1.0) -> list[float]:
    """Plain numbers for a record."""
    return [factor * float(v) for v in values]
