"""Equivalent loads of the standards beside what makers print of them: worked examples, preloaded halves, factors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.compare.cases.external.evidence.case import inputs
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import load_table
from rollbench.lowfi.rating.equivalent import PARTING, equivalent_life, factors, halves, mean_force
from rollbench.lowfi.rating.life import rating

#: Examples of mean forces: key of the entry, and of the case with its phases.
EXAMPLES = {"mean_hiwin_mill": "hiwin_mill", "mean_hiwin": "hiwin", "mean_rexroth": "rexroth"}
#: What makers print for 2^(3/2), and how far [%] that may move the force of a half before the halves part.
ROUNDED, WITHIN = 3.0, 5.0
#: Scene whose ratings the combined life is computed with, its preload and force [N].
SCENE, PRELOAD, FORCE = "external-thk-bnf-4010-5", 5000.0, 3000.0


def mean_of_phases(case: str) -> float:
    """Mean force of phases with forces, speeds and shares of the time, in the unit of the forces."""
    given = inputs()[case]
    turned = np.array(given["speeds"], dtype=float) * np.array(given["time"], dtype=float)
    return float(given.get("factor", 1.0)) * mean_force(turned / turned.sum(), np.array(given["forces"], dtype=float))


def loads(sheet: Sheet, study: Study) -> None:
    """Mean forces, forces and life of preloaded halves, factors of rows by contact angle."""
    for key, case in EXAMPLES.items():
        sheet.number(key, mean_of_phases(case))
    sheet.number("parting", PARTING)
    force = np.linspace(0.0, PARTING, 50)
    loaded, other = halves(force, 1.0)
    lower = error_percent((1.0 + force / ROUNDED) ** 1.5, loaded)
    words = (
        f"with 3 the loaded half's force is {-float(lower.min()):.1f} % lower where the halves part, and no higher anywhere"
    )
    holds = bool((lower <= 1e-9).all() and lower.min() >= -WITHIN and np.allclose(loaded - other, force))
    sheet.claim("loaded_half", holds, words)
    scene = study.scene(SCENE)
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, FORCE)) for x in scene.loads))
    found = equivalent_life([nut], [1.0], [np.array([0.0, 0.0, FORCE])], PRELOAD)
    assert found is not None
    lives = (rating(nut) / np.array(found.loads)) ** 3
    printed = float((lives ** (-10.0 / 9.0)).sum() ** -0.9)
    words = f"{found.revolutions:.4g} 10^6 revolutions, of {lives[0]:.4g} and {lives[1]:.4g}"
    sheet.claim("combined_life", bool(np.isclose(found.revolutions, printed, rtol=1e-12)), words)
    for name, angle in (row.key.split("_") for row in load_table(sheet.table) if row.key[0] in "eXY"):
        sheet.number(f"{name}_{angle}", factors(float(np.radians(float(angle))))["eXY".index(name)])
