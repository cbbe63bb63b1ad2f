"""Table B.1: the Hertz constants as printed, with the source's faults repeated, and right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.comparison.evidence.audit import judge
from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.study import Study, with_groove
from rollbench.comparison.sources.lin.evidence.hertz_b1 import TABLE_CONFORMITY, table_b_1
from rollbench.lowfi.statics.problem import nominal_hertz, printed_sides
from rollbench.reports.records import Column, Section, Table, Text

COLUMNS = (
    Column("label", "quantity", "", "s"),
    Column("unit", "unit", "", "s"),
    Column("printed", "printed", "", "s"),
    Column("as_printed", "as printed, computed", "", "g5"),
    Column("right", "right", "", "g5"),
    Column("error", "as printed against printed", "%", ".3f"),
    Column("fault", "printed against right", "%", ".1f"),
    Column("class", "class", "", "s"),
    Column("verdict", "verdict", "", "s"),
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("Table B.1")
    rows = []
    for f in study.once(table_b_1):
        p = f.printed
        rows.append(
            {
                "label": p.label,
                "unit": p.unit,
                "printed": p.printed,
                "as_printed": f.as_printed,
                "right": f.value,
                "error": f.error_percent,
                "fault": None if f.value is None or p.value is None else float(error_percent(p.value, f.value)),
                "class": p.cls,
                "verdict": judge(f)[0],
            }
        )
    own = study.scene("lin-case1")
    compared = [
        ("Table 2.1's groove, 3.254 mm", own),
        ("Table B.1's groove, 0.56 x diameter", with_groove(own, TABLE_CONFORMITY)),
    ]
    constants = []
    for label, scene in compared:
        right, faulty = nominal_hertz(scene), printed_sides(scene)
        for name, side, printed in zip(("screw", "nut"), (0, 3), faulty, strict=True):
            constants.append(
                {
                    "groove": label,
                    "side": name,
                    "right": float(right.C[side]),
                    "faulty": printed.C,
                    "error": float(error_percent(printed.C, float(right.C[side]))),
                    "a": 1e3 * float(right.C_a[side]) * 225.0 ** (1 / 3),
                    "b": 1e3 * float(right.C_b[side]) * 225.0 ** (1 / 3),
                    "p0": 1e-6 * float(right.pressure(np.array(225.0))[side]),
                    "approach": 1e6 * float(right.C[side]) * 225.0 ** (2 / 3),
                }
            )
    return Section(
        "hertz",
        "Hertz contact: Table B.1",
        (
            Text(
                (
                    "Table B.1 comes out to every printed digit when the source's faults are repeated: groove radius "
                    "0.56 x ball diameter instead of Table 2.1's 3.254 mm, eigenvalues of the second fundamental form "
                    "alone, the correction factor set to 1, and the ratio of B.8 inverted against the table's labels. "
                    "The right values use I⁻¹ II and exact elliptic integrals with the same groove radius.",
                )
            ),
            Table("hertz-B1", "Table B.1: printed, as printed, right", COLUMNS, rows),
            Table(
                "hertz-grooves",
                "What the faults and the groove radius do to the Hertz constant, and the contact at 225 N",
                (
                    Column("groove", "groove", "", "s"),
                    Column("side", "side", "", "s"),
                    Column("right", "C, right", "m/N^(2/3)", "g5"),
                    Column("faulty", "C, as printed", "m/N^(2/3)", "g5"),
                    Column("error", "as printed against right", "%", ".1f"),
                    Column("approach", "approach", "µm", ".3f"),
                    Column("a", "semi-axis a", "mm", ".4f"),
                    Column("b", "semi-axis b", "mm", ".4f"),
                    Column("p0", "pole pressure", "MPa", ".1f"),
                ),
                constants,
            ),
        ),
    )
