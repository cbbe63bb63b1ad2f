"""What is computed for the printed tables of Smith (1994): function, test, scenes."""

from __future__ import annotations

from rollbench.comparison.evidence.registry import Computation

SMITH = "tests/literature/test_smith.py"
SMITH_DATA = "formulas on the document's data: compare/sources/smith/evidence/case.py"
UNEXPLAINED = "printed without what it is computed from: shown, not computed"
MEASURED = "measured by the source: shown, not computed"

COMPUTATIONS = (
    Computation(
        "smith-table-2-1",
        "sources.smith.evidence.ball:table_2_1",
        SMITH,
        (("*", "Hertz's elliptic integrals: no bearing"),),
    ),
    Computation("smith-2.1", "sources.smith.evidence.ball:section_2_1", SMITH, (("*", SMITH_DATA),)),
    Computation("smith-2.2", "sources.smith.evidence.ball:section_2_2", SMITH, (("*", SMITH_DATA),)),
    Computation("smith-2.3", "sources.smith.evidence.ball:section_2_3", SMITH, (("*", SMITH_DATA),)),
    Computation(
        "smith-3",
        "sources.smith.evidence.taper:chapter_3",
        SMITH,
        (("M", UNEXPLAINED), ("M_test", MEASURED), ("*", SMITH_DATA)),
    ),
    Computation("smith-4.1", "sources.smith.evidence.screw:section_4_1", SMITH, (("*", SMITH_DATA),)),
    Computation(
        "smith-4.2",
        "sources.smith.evidence.screw:section_4_2",
        SMITH,
        (
            ("total_ball", ("smith-axis",)),
            ("total_taper", ("smith-axis-taper",)),
            ("supported", ("smith-axis", "smith-axis-supported")),
            ("*", SMITH_DATA),
        ),
    ),
    Computation("smith-4.3", "sources.smith.evidence.screw:section_4_3", SMITH, (("*", UNEXPLAINED),)),
    Computation(
        "smith-5",
        "sources.smith.evidence.trials:chapter_5",
        SMITH,
        (
            *((f"{name}_*", MEASURED) for name in ("accuracy", "reversal", "repeat", "rise", "t750", "t1500")),
            ("*", SMITH_DATA),
        ),
    ),
)
