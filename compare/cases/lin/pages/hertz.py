"""Table B.1: the Hertz constants as printed, with the source's faults repeated, and right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.compare.cases.lin.evidence.chapter_2 import TABLE_CONFORMITY
from rollbench.compare.evidence.computations import evidence
from rollbench.compare.evidence.record import Evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study, with_groove
from rollbench.lowfi.statics.contacts import nominal_hertz, printed_sides
from rollbench.reports.content import Quantity, Row, Section, Table, Text


def _fault(f: Evidence) -> float | None:
    """Error [%] of a printed number against the right one."""
    right, printed = f.value, f.printed.value
    return None if right is None or printed is None else float(error_percent(printed, right))


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("Table B.1")
    rows: list[Row] = []
    for f in evidence(study, "lin-B1"):
        p = f.printed
        rows.append(
            {
                Quantity("label", "quantity", "", "s"): p.label,
                "unit": p.unit,
                "printed": p.printed,
                Quantity("as_printed", "as printed, computed", "", "g5"): f.as_printed,
                Quantity("right", "right", "", "g5"): f.value,
                Quantity("error", "as printed against printed", "%", ".3f"): f.error_percent,
                Quantity("fault", "printed against right", "%", ".1f"): _fault(f),
                "class": p.cls,
                "verdict": f.verdict,
            }
        )
    case = study.scene("lin-case1")
    compared = [
        ("Table 2.1's groove, 3.254 mm", case),
        ("Table B.1's groove, 0.56 x diameter", with_groove(case, TABLE_CONFORMITY)),
    ]
    constants: list[Row] = []
    for label, scene in compared:
        right, faulty = nominal_hertz(scene), printed_sides(scene)
        for name, side, printed in zip(("screw", "nut"), (0, 3), faulty, strict=True):
            C = float(right.C[side])
            constants.append(
                {
                    "groove": label,
                    "side": name,
                    Quantity("right", "C, right", "m/N^(2/3)", "g5"): C,
                    Quantity("faulty", "C, as printed", "m/N^(2/3)", "g5"): printed.C,
                    Quantity("error", "as printed against right", "%", ".1f"): float(error_percent(printed.C, C)),
                    Quantity("approach", "approach", "µm", ".3f"): 1e6 * C * 225.0 ** (2 / 3),
                    Quantity("a", "semi-axis a", "mm", ".4f"): 1e3 * float(right.C_a[side]) * 225.0 ** (1 / 3),
                    Quantity("b", "semi-axis b", "mm", ".4f"): 1e3 * float(right.C_b[side]) * 225.0 ** (1 / 3),
                    Quantity("p0", "pole pressure", "MPa", ".1f"): 1e-6 * float(right.pressure(np.array(225.0))[side]),
                }
            )
    return Section(
        "hertz",
        "Hertz contact: Table B.1",
        (
            Text(
                (
                    "Table B.1 comes out to every printed digit when the source's faults are repeated: a groove radius "
                    "of 0.56 ball diameters instead of Table 2.1's 3.254 mm, eigenvalues of the second fundamental form "
                    "alone, a correction factor of 1, and the ratio of B.8 inverted against the table's labels. The "
                    "right values use I⁻¹ II and exact elliptic integrals with the same groove radius.",
                )
            ),
            Table.of("hertz-B1", "Table B.1: printed, as printed, right", rows),
            Table.of(
                "hertz-grooves",
                "What the faults and the groove radius do to the Hertz constant, and the contact at 225 N",
                constants,
            ),
        ),
    )
