"""Liu, section 4.2: one ball too small or too large by 2 um."""

from __future__ import annotations

import numpy as np

from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.liu.evidence import case
from rollbench.comparison.wings.evidence.entries import Entries
from rollbench.comparison.wings.evidence.record import Evidence
from rollbench.lowfi.random_errors.chain import first_carrying_load
from rollbench.meshes.roots import brentq

LIGHT, HEAVY = 1000.0, 5000.0


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


def section_4_2(study: Study) -> tuple[Evidence, ...]:  # noqa: ARG001 - every table takes the study
    """Section 4.2."""
    e = Entries("liu-4.2")
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
    return e.evidence()
