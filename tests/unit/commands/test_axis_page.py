"""Pages of several sets on a shaft: the numbers of the results, each set on the view, load cases."""

import json
import re
from pathlib import Path

import pytest
from tests.axes import CASES, ON_A_SHAFT

import rollbench
from rollbench.compare.errors import ArgumentError
from rollbench.compare.report import scene_page, verify
from rollbench.reports.scene_page import read_page_data, scene_page_html

pytestmark = pytest.mark.xdist_group("axis page")

STORES = (scene_page.shipped_store(),)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the arrangement under load cases."""
    found = tmp_path_factory.mktemp("axis")
    (found / "cases.toml").write_text(ON_A_SHAFT.read_text() + CASES)
    return found


def test_the_page_of_an_axis_has_the_numbers_of_its_results():
    page = scene_page.solve_and_make_page("smith-axis-taper", STORES)
    html, solved = scene_page_html(page), rollbench.solve("smith-axis-taper")
    assert page.verdict.startswith("The contact with the highest pressure, in right 1, carries")
    tables = {item.name: item.rows for part in page.parts for item in part.items if hasattr(item, "rows")}
    assert [row["load"] for row in tables["rollers"]] == pytest.approx(
        [load for s in solved.sets.values() for load in s.roller_loads]
    )
    shown = [float(row["axial force N"]) for row in tables["sets"]]
    assert shown == pytest.approx([s.force[2] for s in solved.sets.values()], rel=1e-3)
    view = json.loads(re.search(r'id="view-data">(.*?)</script>', html, flags=re.DOTALL)[1])
    assert [one["name"] for one in view["cases"][0]["sets"]] == [*solved.sets]
    assert {row.comparison_result for row in verify.check_page_hashes(html, read_page_data(html), STORES)} == {"ok"}


def test_load_cases_of_an_axis_are_on_its_page_and_side_by_side(folder):
    said = verify.write_and_compare_pages([str(folder / "cases.toml"), "smith-axis-taper"], folder / "out", folder)
    assert said.exit_code == 0
    page = read_page_data((folder / "out" / "cases.html").read_text(encoding="utf-8"))["results"]
    index = (folder / "out" / "index.html").read_text(encoding="utf-8")
    for words, group, key in (
        ("worst contact: pressure", "worst_contact", "pressure_MPa"),
        ("axis life: L10", "axis_life", ""),
    ):
        line = next(x for x in re.findall(r"<tr>(.*?)</tr>", index, flags=re.DOTALL) if words in x)
        shown = [float(x) for x in re.findall(r"<td[^>]*>([^<]*)", line)[2:4]]
        of = [case["summary"][group][key or "L10_million_revolutions"] for case in page["cases"]]
        assert shown == pytest.approx(of, rel=6e-4)


def test_a_reference_of_several_sets_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="a single nut or bearing"):
        scene_page.solve_and_make_page(str(ON_A_SHAFT), STORES, Path(tmp_path / "any.csv"))
