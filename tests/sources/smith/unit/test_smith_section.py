"""Smith's section of the report: tables as filed, figure drawable, misprints listed, US units readable."""

from collections import Counter

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import figures
from tests.sources.entries import of_source

from rollbench.compare.cases.smith import page as smith
from rollbench.compare.cases.smith.evidence import bearings
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.printed import load_printed_table
from rollbench.meshes import units

pytestmark = pytest.mark.xdist_group(GROUP)


def test_stiffness_of_a_symmetric_axis_is_symmetric():
    found = [figure for section in smith.make_section(STUDY, lambda _: None) for figure in figures(section)]
    lines = {s.label: s.y for figure in found for panel in figure.panels for s in panel.series}
    assert lines["ball, fixed-fixed"] == pytest.approx(lines["ball, fixed-fixed"][::-1])
    assert np.all(np.diff(lines["taper, fixed-supported"]) < 0.0)


def test_every_unit_of_force_length_and_stiffness_is_readable():
    dimension = dict.fromkeys(("lbf", "N"), "force") | dict.fromkeys(("in", "mm", "uin"), "length")
    dimension |= dict.fromkeys(("deg", "rad"), "angle") | {"in-lbf": "moment", "lbf/in": "stiffness"}
    dimension |= {"psi": "pressure", "degF": "temperature difference"}
    used = Counter(row.unit for name in of_source("smith") for row in load_printed_table(name) if row.number_as_printed)
    for unit in used:
        if unit in dimension:
            assert units.parse_quantity(f"1 {unit}", dimension[unit]) > 0.0
    assert sum(used[u] for u in dimension) > 180
    assert set(used) - set(dimension) == {
        "",
        "N/mm^1.5",
        "1/mm",
        "in^2",
        "cSt",
        "rpm",
        "kg",
        "kg/mm2",
        "1/degF",
        "%",
        "in/min",
    }


def test_case_in_si():
    b, t = bearings.smith_ball_bearing(), bearings.smith_tapered_bearing()
    assert b.ball_diameter == pytest.approx(8.73125e-3, rel=1e-12)
    assert t.cup_angle == pytest.approx(np.radians(30.8))
    assert pytest.approx(4.4482216152605 / 0.0254) == bearings.POUND_PER_INCH
    with pytest.raises(KeyError, match="four_times"):
        ComputedEntryValues("smith-5").printed("four_times")
