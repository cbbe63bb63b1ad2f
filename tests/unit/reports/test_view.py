"""The page on which a solved scene can be turned: what it holds, and in Debian's Chromium, at the width of a screen and of
a phone, without network: it draws, turns, and shows the numbers of the JSON, with nothing on its console."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.browser import browser
from tests.load_cases import case
from tests.report_samples import WITH_CHROMIUM

import rollbench
from rollbench.compare.results.view import gap_reduction_by_errors
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import hertz_of_every_contact
from rollbench.lowfi.statics.result import Status
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, FourierTerm, SideErrors
from rollbench.reports import view

WIDTHS = {1400: 900, 390: 844}
CASES = case("light", "1 kN", share=0.6) + case("heavy", "3 kN", share=0.4)


def block(html, name):
    (text,) = re.findall(rf'<script type="application/json" id="{name}">(.*?)</script>', html, re.DOTALL)
    return json.loads(text)


def test_the_page_holds_the_results_and_loads_nothing(tmp_path):
    result = rollbench.solve("two-balls", "lin")
    html = result.view(tmp_path / "screw.html").read_text(encoding="utf-8")
    assert view.MARKER in html
    assert block(html, "results") == json.loads(json.dumps(result.to_dict()))
    assert not re.search(r'(src|href)="', html)
    assert not re.search(r"""(?:fetch|import|XMLHttpRequest|WebSocket)\(["'`]http""", html)
    assert "MIT licence" in html


def test_a_title_cannot_leave_its_place():
    one = replace(catalogue.scene("two-balls"), title="</title><script>alert(1)</script>")
    html = rollbench.solve(one, "lin").view_page()
    assert "<script>alert" not in html


def test_without_loads_there_is_no_view(tmp_path):
    result = rollbench.solve("two-balls", "lin")
    lost = replace(result, solution=replace(result.solution, status=Status("not held")))
    with pytest.raises(ValueError, match="no loads to draw"):
        lost.view(tmp_path / "none.html")
    assert not (tmp_path / "none.html").exists()


def test_pressures_of_the_rows_are_hertz_of_their_loads():
    """By Hertz, p is in proportion to the cube root of the load; of the worst contact it is what the summary says."""
    data, scene = rollbench.solve("lin-case3-offset", "lin").to_dict(), catalogue.scene("lin-case3-offset")
    keys = "load_N", "pressure_MPa"
    load, pressure = (np.array([[row[key][s] for s in SIDES] for row in data["balls"]]) for key in keys)
    assert pressure.max() == pytest.approx(data["summary"]["worst_contact"]["pressure_MPa"], rel=1e-9)
    law = hertz_of_every_contact(scene, draw_geometry_with_errors(scene, ball_layout(scene))).pressure(np.ones_like(load))
    np.testing.assert_allclose(pressure, 1e-6 * law * np.cbrt(load), rtol=1e-9)


def test_errors_of_the_parts_bring_contacts_closer():
    """A larger ball by its oversize, a flank's pitch error by its part along the contact normal, on that flank only."""
    scene, beta = catalogue.scene("lin-case1"), catalogue.scene("lin-case1").track.contact_angle
    np.testing.assert_allclose(gap_reduction_by_errors(scene), 0.0, atol=1e-18)
    larger = replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, oversize=2e-6)))
    np.testing.assert_allclose(gap_reduction_by_errors(larger), 2e-6, rtol=1e-9)
    wave = SideErrors(pitch=(FourierTerm(1, 5e-6, 0.0),))
    found = gap_reduction_by_errors(replace(scene, errors=replace(scene.errors, SR=wave)))
    azimuth = ball_layout(scene).azimuth
    np.testing.assert_allclose(found[:, [0, 2, 3]], 0.0, atol=1e-18)
    np.testing.assert_allclose(found[:, 1], -5e-6 * np.sin(azimuth) * np.sin(beta), atol=1e-12)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Views of a screw, of load cases, of several sets, and of tapered rollers, with their results."""
    folder = tmp_path_factory.mktemp("views")
    cycle = folder / "cycle.toml"
    cycle.write_text(catalogue.shipped_scene_text("lin-case1").split("[[loads]]")[0] + CASES, encoding="utf-8")
    scenes = {"screw": "lin-case3-offset", "cases": cycle, "sets": "double-nut", "rollers": "smith-axis-taper"}
    solved = {name: rollbench.solve(scene, "lin") for name, scene in scenes.items()}
    return {name: (one.view(folder / f"{name}.html"), one.to_dict()) for name, one in solved.items()}


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("user")) as found:
        yield found


@pytest.fixture
def page(tab):
    """The tab, whose console must be given nothing."""
    tab.console.clear()
    yield tab
    assert tab.console == []


def in_chromium(test):
    """Marks a test that needs the browser."""
    return pytest.mark.slow(WITH_CHROMIUM(pytest.mark.xdist_group("view")(test)))


def seen(page):
    """The text of the value that is shown, line by line; nothing where none is."""
    return page.run("(() => { const v = document.getElementById('view-value'); return v.hidden ? '' : v.innerText; })()")


#: Places of the canvas at which other balls or rollers have values, as the page's own handler finds them.
SEARCH = """(() => {
  const canvas = document.getElementById("view-canvas"), box = canvas.getBoundingClientRect(), found = {};
  for (let y = 0.2; y < 0.8; y += 0.06) for (let x = 0.1; x < 0.9; x += 0.05) {
    const at = { clientX: box.left + x * box.width, clientY: box.top + y * box.height };
    canvas.dispatchEvent(new PointerEvent("pointermove", at));
    const value = document.getElementById("view-value"), name = value.hidden ? "" : value.querySelector("b").textContent;
    if (name) found[name] ??= [at.clientX, at.clientY];
  }
  return Object.values(found);
})()"""


def over_balls(page, most=4):
    """Moves the mouse over so many balls or rollers: what is shown of each, by number."""
    page.box("#view-canvas")
    found = {}
    places = page.run(SEARCH)
    for x, y in places[:: max(1, len(places) // most)][:most]:
        page.mouse("mouseMoved", x, y)
        text = seen(page)
        found[int(re.search(r"(?:ball|roller) (\d+)", text)[1])] = text
    return found


def same(text, row):
    """Whether a text shows load, pressure and angle of the contacts that a row loads, to the digits that it shows."""
    lines = re.findall(r"(SL|SR|NL|NR)\s+([\d.]+) N\s+([\d.]+) MPa\s+([\d.]+)°", text)
    for side, *numbers in lines:
        values = [row[key][side] for key in ("load_N", "pressure_MPa", "contact_angle_deg")]
        assert [float(x) for x in numbers] == pytest.approx(values, rel=6e-5, abs=0.006), text
    loaded = [side for side in SIDES if row["load_N"][side] > 0.0]
    return [line[0] for line in lines] in (loaded, *[[side] for side in loaded])


@in_chromium
@pytest.mark.parametrize("width", WIDTHS)
def test_it_is_drawn_turns_and_shows_the_numbers_of_the_json(page, pages, width):
    path, data = pages["screw"]
    page.open(path, width, WIDTHS[width])
    before = page.picture("#view-canvas")
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 1000, "a blank canvas has a few colours"
    found = over_balls(page)
    assert len(found) == 4, found
    rows = {row["index"]: row for row in data["balls"]}
    assert all(same(text, rows[number]) for number, text in found.items())
    left, top, w, h = page.box("#view-canvas")
    page.drag((left + 0.5 * w, top + 0.6 * h), (left + 0.7 * w, top + 0.5 * h))
    page.mouse("mouseMoved", left + 2, top + 2)
    page.settle()
    after = page.picture("#view-canvas")
    assert (np.abs(after - before).max(axis=2) > 20).mean() > 0.03, "the scene has turned"
    assert all(same(text, rows[number]) for number, text in over_balls(page).items())
    assert page.run("document.documentElement.scrollWidth <= innerWidth")


@in_chromium
@pytest.mark.parametrize("width", WIDTHS)
def test_curves_show_the_same_numbers_and_stay_on_the_page(page, pages, width):
    path, data = pages["screw"]
    page.open(path, width, WIDTHS[width])
    assert page.run("document.querySelectorAll('#view-curves b').length") == 3, (
        "clearances that are equal everywhere: no curve"
    )
    left, top, w, h = page.box("#view-curves svg")
    for share in (0.3, 0.6, 0.9):
        page.mouse("mouseMoved", left + share * w, top + 0.5 * h)
        number = int(re.search(r"ball (\d+)", seen(page))[1])
        assert number == pytest.approx(share * len(data["balls"]), abs=4)
        assert same(seen(page), data["balls"][number - 1])


@in_chromium
def test_tabs_show_load_cases_and_sets(page, pages):
    path, data = pages["cases"]
    page.open(path, 1400, 900)
    assert page.run("[...document.querySelectorAll('#view-cases button')].map(b => b.textContent)") == ["light", "heavy"]
    for k, of_case in enumerate(data["cases"]):
        page.run(f"document.querySelectorAll('#view-cases button')[{k}].click()")
        texts = over_balls(page, 3)
        assert len(texts) == 3
        assert all(same(text, of_case["balls"][number - 1]) for number, text in texts.items())
    path, data = pages["sets"]
    page.open(path, 1400, 900)
    assert page.run("document.querySelectorAll('#view-curves svg').length") == 0
    page.run("[...document.querySelectorAll('#view-sets button')].find(b => b.textContent === 'nut 2').click()")
    rows = [row for row in data["balls"] if row["set"] == 2]
    texts = {number: text for number, text in over_balls(page, 6).items() if text.startswith("nut 2")}
    assert len(texts) > 3
    assert all(same(text, rows[number - 1]) for number, text in texts.items())


@in_chromium
def test_rollers_have_their_loads(page, pages):
    path, data = pages["rollers"]
    page.open(path, 1400, 900)
    row = next(k for k, one in enumerate(data["sets"], 1) if any(r["set"] == k and r["load_N"] for r in data["rollers"]))
    page.run(f"document.querySelectorAll('#view-sets button')[{row}].click()")
    name = data["sets"][row - 1]["name"]
    texts = {number: text for number, text in over_balls(page, 6).items() if text.startswith(f"{name}, roller")}
    assert len(texts) > 2
    loads = {r["index"]: r["load_N"] for r in data["rollers"] if r["set"] == row}
    for number, text in texts.items():
        assert float(re.search(r"load\s+([\d.]+) N", text)[1]) == pytest.approx(loads[number], rel=6e-5)
