"""Shared by the tests of reports: a figure, a table, a loaded screw, a report of them, and the files of a folder."""

import math

import numpy as np

from rollbench.reports.records import Figure, LoadedScrew, Page, Panel, Quantity, Report, Section, Series, Table, Text


def figure(name="loads", **changes):
    ball = [1, 2, 3, 4]
    curves = (
        Series("computed", ball, [210.0, 220.0, 230.0, 225.0], emphasis=True),
        Series("printed", ball, [211.0, 219.0, math.nan, 226.0], "markers"),
        Series("source", ball, [212.0, 222.0, 232.0, 227.0], "line"),
        Series("95 % band", ball, [200.0, 210.0, 220.0, 215.0], "band", [220.0, 230.0, 240.0, 235.0]),
    )
    panels = (
        Panel("Case <1>", "ball number", "normal force [N]", curves, integer_x=True, zero=True),
        Panel("Error", "load [N]", "error [–]", [Series("computed", [1, 10, 1e6], [1e-9, 0.0, 1e-3])], log="xy"),
    )
    return Figure(**{"name": name, "title": "Loads & errors", "panels": panels, "caption": "Axial load."} | changes)


def table(name="printed"):
    columns = (
        Quantity("q", "Quantity, of all", format="s"),
        Quantity("force", "Force", "N"),
        Quantity("error", "Error", "%", ".2f"),
        Quantity("class", "Class", format="s"),
        Quantity("verdict", "Verdict", format="s"),
        Quantity("ok", "Met"),
    )
    rows = (
        {"q": '<b>"a"</b>', "force": 1.0 / 3.0, "error": -0.5, "class": "hard", "verdict": "reproduced", "ok": True},
        {"q": "b, c", "force": None, "error": math.nan, "class": "open", "verdict": "contradicted", "ok": False},
        {"q": "two\nlines", "force": np.float64(2.1e8), "class": "as-printed", "verdict": "open", "ok": np.True_},
    )
    return Table(name, "Printed <and> computed", columns, rows, note="Error: 1 < 2.")


def screw(lead=0.02, groove_radius=0.003254):
    turns = 2 if lead else 1
    phi = (np.arange(16 * turns) - 8 * turns) * 2.0 * np.pi / 16
    track, ball, position = 0.0165, 0.002778, 0.4
    path = np.linspace(phi[0], phi[-1], 100)

    def on_track(azimuth):
        height = position + lead * azimuth / (2.0 * np.pi)
        return np.stack([track * np.cos(azimuth), track * np.sin(azimuth), height], axis=1)

    radial = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=1)
    line = (radial + np.array([0.0, 0.0, 1.0])) / np.sqrt(2.0)
    force = 225.0 + 8.0 * np.cos(phi)[:, None]
    return LoadedScrew(
        name="screw",
        title="The loaded screw",
        screw_length=0.8,
        screw_radius=0.016,
        nut_position=position,
        nut_length=0.054,
        nut_radius=0.024,
        track_radius=track,
        ball_radius=ball,
        ball_radii_centres=on_track(phi),
        ball_loads=force[:, 0],
        helix=on_track(path),
        contact_points=np.concatenate([on_track(phi) - ball * line, on_track(phi) + ball * line]),
        contact_forces=np.concatenate([force * line, -force * line]),
        groove_radius=groove_radius,
        lead=lead,
        caption="Arrows are forces.",
    )


def report(*items):
    sections = (
        Section("first", "First & foremost", items or (Text(["A < B."]), table(), figure())),
        Section(
            "second", "Second", (Text(["one", "two <i>"], bullets=True), Table("empty", "None", [Quantity("a", "A")], []))
        ),
    )
    provenance = {"Version": "1.2.3", "Machine": "<unknown>"}
    return Report("Report <1>", "Sub & title", provenance, paged(*sections))


def paged(*sections):
    """Each section on a page of its own name."""
    return [Page(section.name, section.title, (section,), section.conclusion) for section in sections]


def contents(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
