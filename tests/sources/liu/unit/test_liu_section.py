"""Liu's section of the report: tables as filed, figure drawable, misprints listed."""

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY

from rollbench.comparison.printed.printed_data import load_table
from rollbench.comparison.sources.liu import section as liu
from rollbench.comparison.sources.liu.evidence import bodies
from rollbench.reports.figures import draw
from rollbench.reports.records import Figure, Table

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.fixture(scope="module")
def made():
    return liu.section(STUDY, lambda _: None)


def test_tables_show_every_entry(made):
    tables = {item.name: item for item in made.items if isinstance(item, Table)}
    solid = ["liu-solid"] if STUDY.references(bodies.SOLID) else []
    assert list(tables) == [*liu.TITLES, "liu-bodies", *solid]
    for name in liu.TITLES:
        assert [r["printed"] for r in tables[name].rows] == [p.printed or "–" for p in load_table(name)]
        assert all(row["verdict"] for row in tables[name].rows)


def test_figure_can_be_drawn(made):
    (figure,) = (item for item in made.items if isinstance(item, Figure))
    for panel in figure.panels:
        for series in panel.series:
            assert len(series.x) == len(series.y) >= 1
            assert np.all(np.isfinite(series.y))
    assert draw(figure).startswith("<?xml")
    counts = next(s for s in figure.panels[0].series if s.label == "printed")
    # loaded at 1000 N: 78 less the printed 16, 17 and 35
    assert sorted(y for x, y in zip(counts.x, counts.y, strict=True) if x == 1000.0) == [43.0, 61.0, 62.0]
