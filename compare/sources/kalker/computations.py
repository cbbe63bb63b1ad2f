"""What is computed for the printed tables of Kalker's table: function, test, scenes."""

from __future__ import annotations

from rollbench.comparison.evidence.registry import Computation

KALKER = "tests/literature/test_kalker.py"

COMPUTATIONS = (
    Computation(
        "kalker-E3",
        "sources.kalker.evidence:table_e3",
        KALKER,
        (("*", "one contact of half spaces, of the table's ellipse and material"),),
    ),
)
