"""Liu's section of the report: what the text prints of unloaded balls stands on its curve."""

import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import figures

from rollbench.compare.cases.liu import page as liu

pytestmark = pytest.mark.xdist_group(GROUP)


def test_printed_counts_stand_on_the_figure():
    found = [figure for section in liu.make_section(STUDY, lambda _: None) for figure in figures(section)]
    printed = [s for figure in found for panel in figure.panels for s in panel.series if s.label == "printed"]
    # loaded at 1000 N: 78 less the printed 16, 17 and 35
    assert {43.0, 61.0, 62.0} <= {y for s in printed for x, y in zip(s.x, s.y, strict=True) if x == 1000.0}
