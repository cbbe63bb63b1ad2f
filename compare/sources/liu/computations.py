"""What is computed for the printed tables of Liu et al. (2025): function, test, scenes."""

from __future__ import annotations

from rollbench.comparison.evidence.registry import Computation

LIU = "tests/literature/test_liu.py"
MEASURED = "measured by the source: shown, not computed"
WORDING = "a formula of the source, judged as printed"
LIU_SCREW = ("*", ("liu-screw",))

COMPUTATIONS = (
    Computation(
        "liu-2",
        "sources.liu.evidence.given:section_2",
        LIU,
        (("v_2pi", ()), ("*_error", ()), ("e_?", ()), ("plus_or_minus", WORDING), LIU_SCREW),
    ),
    Computation(
        "liu-3",
        "sources.liu.evidence.given:section_3",
        LIU,
        (("load", ()), ("free_length", ()), ("deviation", MEASURED), LIU_SCREW),
    ),
    Computation("liu-4.1", "sources.liu.evidence.given:section_4_1", LIU, (LIU_SCREW,)),
    Computation("liu-4.2", "sources.liu.evidence.single_error:section_4_2", LIU, (LIU_SCREW,)),
    Computation("liu-4.3", "sources.liu.evidence.drawn:section_4_3", LIU, (LIU_SCREW,)),
    Computation("liu-4.4", "sources.liu.evidence.drawn:section_4_4", LIU, (("spread_*", ()), LIU_SCREW)),
)
