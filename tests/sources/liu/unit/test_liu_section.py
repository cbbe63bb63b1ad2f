"""Liu's section of the report: tables as filed, figure drawable, misprints listed."""

import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import drawn, figures, shows_entries, tables

from rollbench.compare.cases.liu import bodies
from rollbench.compare.cases.liu import page as liu

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.fixture(scope="module")
def section():
    return liu.section(STUDY, lambda _: None)


def test_tables_show_every_entry(section):
    shown = tables(section)
    solid = ["liu-solid"] if STUDY.references(bodies.SOLID) else []
    assert list(shown) == [*liu.TITLES, "liu-bodies", *solid]
    for name in liu.TITLES:
        shows_entries(shown[name], name)


def test_figure_can_be_drawn(section):
    (figure,) = figures(section)
    drawn([figure])
    counts = next(s for s in figure.panels[0].series if s.label == "printed")
    # loaded at 1000 N: 78 less the printed 16, 17 and 35
    assert sorted(y for x, y in zip(counts.x, counts.y, strict=True) if x == 1000.0) == [43.0, 61.0, 62.0]
