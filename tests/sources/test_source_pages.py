"""The page of a source: every number that it prints, with ours as ``rollbench check --printed`` judges it, and figures."""

from collections import Counter
from functools import cache

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import drawn, figures, tables
from tests.sources.entries import of_source

from rollbench.compare.cases.lin.pages import tables as lin
from rollbench.compare.cases.liu import page as liu
from rollbench.compare.cases.smith import page as smith
from rollbench.compare.evidence import evidence
from rollbench.compare.printed import VERDICT_NAMES
from rollbench.reports.content import table_column

pytestmark = pytest.mark.xdist_group(GROUP)

PAGES = {"lin": lin, "liu": liu, "smith": smith}


@cache
def sections(source):
    return PAGES[source].make_section(STUDY, lambda _: None)


def shown(source):
    """Rows of tables that show printed numbers."""
    every = [table for section in sections(source) for table in tables(section).values()]
    return [row for table in every if not table.name.startswith("how-") for row in table.rows]


@pytest.mark.parametrize("source", PAGES)
def test_every_printed_number_is_shown(source):
    numbers = [f.printed.number_as_printed for f in evidence(STUDY, *of_source(source)) if not f.printed.claim]
    cells = [
        value
        for row in shown(source)
        for key, value in row.items()
        if key in ("printed", "printed_run_time") or table_column(key).key.startswith("printed-")
    ]
    listed = Counter(str(cell).split(" ")[0] for cell in cells)
    assert {number: n for number, n in Counter(numbers).items() if listed[number] < n} == {}


@pytest.mark.parametrize("source", PAGES)
def test_a_row_has_the_value_and_the_verdict_of_the_judge(source):
    found = [f for f in evidence(STUDY, *of_source(source)) if f.printed.entry_class != "input" and not f.printed.claim]
    verdicts = {(f.printed.number_as_printed, VERDICT_NAMES[f.verdict]) for f in found}
    values = [f.value for f in found if f.value is not None]
    rows = [
        (cell, row)
        for row in shown(source)
        for key, cell in row.items()
        if (key == "value_correct" or (isinstance(key, tuple) and key[0] == "value_low_order"))
        and isinstance(cell, float)
        and row["verdict"] != "input"
    ]
    assert len(rows) > 20
    for computed, row in rows:
        assert computed == pytest.approx(min(values, key=lambda value, computed=computed: abs(value - computed)), abs=1e-9)
        assert (str(row["printed"]).split(" ")[0], row["verdict"]) in verdicts


@pytest.mark.parametrize("source", PAGES)
def test_figures_can_be_drawn(source):
    found = [figure for section in sections(source) for figure in figures(section)]
    assert found
    drawn(found, finite=0.8)


def curves(source):
    """All series of the figures of a source's page."""
    found = [figure for section in sections(source) for figure in figures(section)]
    return [series for figure in found for panel in figure.panels for series in panel.series]


def test_liu_s_printed_counts_stand_on_the_figure():
    printed = [s for s in curves("liu") if s.label == "printed"]
    # loaded at 1000 N: 78 less the printed 16, 17 and 35
    assert {43.0, 61.0, 62.0} <= {y for s in printed for x, y in zip(s.x, s.y, strict=True) if x == 1000.0}


def test_stiffness_of_smith_s_symmetric_axis_is_symmetric():
    lines = {s.label: s.y for s in curves("smith")}
    assert lines["ball, fixed-fixed"] == pytest.approx(lines["ball, fixed-fixed"][::-1])
    assert np.all(np.diff(lines["taper, fixed-supported"]) < 0.0)
