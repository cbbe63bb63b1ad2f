"""Shared by the tests of reports: a figure, a table, a loaded screw, a report of them, and the files of a folder."""

import math
import shutil
from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.meshes.helix import ball_layout
from rollbench.reports.content import Figure, LoadedScrew, Page, Panel, Report, Section, Series, Table, TableColumn, Text

CHROMIUM = shutil.which("chromium")
WITH_CHROMIUM = pytest.mark.skipif(CHROMIUM is None, reason="needs Debian's chromium")


def image(draw, what, path):
    """The bytes of a PNG that a function draws, where this machine can."""
    try:
        draw(what, path)
    except RuntimeError as error:
        if "libgl1" in str(error) or "OpenGL" in str(error):
            pytest.skip(str(error))
        raise
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    return data


def figure(name="loads", **changes):
    ball = [1, 2, 3, 4]
    curves = (
        Series("computed", ball, [210.0, 220.0, 230.0, 225.0], bold=True),
        Series("printed", ball, [211.0, 219.0, math.nan, 226.0], "markers"),
        Series("source", ball, [212.0, 222.0, 232.0, 227.0], "line"),
        Series("95 % band", ball, [200.0, 210.0, 220.0, 215.0], "band", [220.0, 230.0, 240.0, 235.0]),
    )
    panels = (
        Panel("Case <1>", "ball number", "normal force [N]", curves, integer_x=True, include_zero=True),
        Panel("Error", "load [N]", "error [–]", [Series("computed", [1, 10, 1e6], [1e-9, 0.0, 1e-3])], log_axes="xy"),
    )
    return Figure(**{"name": name, "title": "Loads & errors", "panels": panels, "caption": "Axial load."} | changes)


def table(name="printed"):
    columns = {
        TableColumn("q", "Quantity, of all", format="s"): ['<b>"a"</b>', "b, c", "two\nlines"],
        TableColumn("force", "Force", "N"): [1.0 / 3.0, None, np.float64(2.1e8)],
        TableColumn("error", "Error", "%", ".2f"): [-0.5, math.nan, None],
        TableColumn("class", "Class", format="s", mark="class"): ["hard", "open", "as-printed"],
        TableColumn("verdict", "Verdict", format="s", mark="verdict"): ["reproduced", "contradicted", "open"],
        TableColumn("ok", "Met"): [True, False, np.True_],
    }
    return Table(name, "Printed <and> computed", columns, note="Error: 1 < 2.")


def screw(scene="lin-case1", **changes):
    """Balls of a shipped scene pressed between two flanks, by forces that differ around it."""
    parts = catalogue.scene(scene)
    layout, load = ball_layout(parts), np.zeros((parts.ball_count, 4))
    load[:, [0, 3]] = 225.0 + 8.0 * np.cos(layout.azimuth)[:, None]
    line = (layout.radial + layout.binormal) / np.sqrt(2.0)
    force, arm = load[:, :1] * line, parts.balls.radius * line
    points = np.concatenate([layout.centre - arm, layout.centre + arm])
    picture = LoadedScrew("screw", "The loaded screw", parts, load, points, np.concatenate([force, -force]), "Arrows.")
    return replace(picture, **changes)


def report(*items):
    empty = Table("empty", "None", {TableColumn("a", "A"): []})
    sections = (
        Section("first", "First & foremost", items or (Text(["A < B."]), table(), figure())),
        Section("second", "Second", (Text(["one", "two <i>"], bullets=True), empty)),
    )
    provenance = {"Version": "1.2.3", "Machine": "<unknown>"}
    return Report("Report <1>", "Sub & title", provenance, paged(*sections))


def paged(*sections):
    """Each section on a page of its own name."""
    return [Page(section.name, section.title, (section,), section.conclusion) for section in sections]


def contents(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
