"""Error against run time: one definition of error and error bar for all points; tables of levels and convergence."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.assembly_ways import OURS, VECTOR, WAYS, assembly_costs, meshes

from rollbench.compare.models import comparison, ladder, study
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.sections import reference_mesh as reference_mesh
from rollbench.compare.sections import reference_time
from rollbench.compare.sections.reference import LABELS as NAMES
from rollbench.compare.sections.reference_time import FLOOR, Largest, TimePoint, time_figures, time_panel, time_table
from rollbench.reports import content, figures

STUDY = study.Study()


@cache
def stored():
    return STUDY.references((*comparison.REFERENCED, *ladder.UNSEEN))


def test_every_point_has_the_same_reference_and_its_bar() -> None:
    found = stored()["lin-case1"]
    assert reference_time.errors_of(found.load, found)["error"] == 0.0
    same = reference_time.errors_of(found.best.load, found)
    unit = 100.0 / found.load[found.load > 0.0].mean()
    off, bar = unit * np.abs(found.best.load - found.load), unit * found.uncertainty
    ends = off.max(), max(0.0, (off - bar).max()), (off + bar).max()
    assert (same["error"], same["low"], same["high"]) == pytest.approx(ends)
    more = reference_time.errors_of(found.load * 1.05, found)
    assert 0.0 < more["low"] < more["error"] < more["high"]
    assert more["rms"] < more["error"]
    assert more["gate"].error == pytest.approx(5.0)


def point(label: str, kind: str, error: float, cold: float, **changes: object) -> TimePoint:
    measured = TimePoint(
        label,
        kind,
        error,
        error / 2,
        max(0.0, error - 1.0),
        error + 1.0,
        cold,
        0.1,
        65,
        100.0,
        label,
        Largest(error, error, error),
    )
    return replace(measured, **changes)


def test_every_way_to_assemble_gives_the_same_matrix_and_ours_is_the_fastest() -> None:
    costs = assembly_costs(share=0.3, repeats=1)
    assert {(cost.mesh, cost.way) for cost in costs} == {(mesh, way) for mesh in meshes(0.3) for way in WAYS}
    assert max(cost.difference for cost in costs) < 1e-12
    ours = {cost.mesh: cost.seconds for cost in costs if cost.way == OURS}
    assert all(cost.seconds > 2.0 * ours[cost.mesh] for cost in costs if cost.way == VECTOR)


def test_figure_draws_levels_as_one_curve_with_bars_and_leaves_failures_out() -> None:
    points = [
        point("a model", "model", 3.0, 1.0),
        point("failed", "model", 3.0, 1.0, status="no convergence"),
        point("mesh", "source mesh", 2.0, 20.0),
        point("level 1", "level", 0.5, 40.0),
        point("level 2", "level", 0.0, 90.0),
    ]
    panel = time_panel("x", points)
    curves = {s.label: s for s in panel.series}
    assert set(curves) == {"a model", "mesh", "3D reference, its levels"}
    levels = curves["3D reference, its levels"]
    assert list(levels.y) == [0.5, FLOOR]
    assert levels.bars == ([FLOOR, FLOOR], [1.5, 1.0])
    plain = time_panel("x", [replace(p, low=None, high=None) for p in points])
    assert all(s.bars is None for s in plain.series)
    with_bars, without = (figures.draw(content.Figure("f", "t", (p,))) for p in (panel, plain))
    assert with_bars.count("LineCollection") > without.count("LineCollection")
    rows = time_table({"x": points}).rows
    assert [r["status"] for r in rows] == ["", "no convergence", "", "", ""]
    assert time_table({"x": [point("m", "model", 1.0, 1.0, memory=None)]}).rows[0]["memory"] == "not measured"


def test_unseen_scenes_have_a_figure() -> None:
    axial = point(reference_time.MODELS["mei"].label, "model", 9.0, 1.0, name="mei")
    level = point("level 1", "level", 0.5, 40.0)
    points = {"lin-case1": [axial, level], "lin-case3": [level], ladder.UNSEEN[0]: [level], ladder.UNSEEN[1]: [level]}
    names = {f.name: [p.title for p in f.panels] for f in time_figures(points)}
    expected = {"": ["lin-case1"], "-preload": ["lin-case3"], "-unseen": [ladder.UNSEEN[0], ladder.UNSEEN[1]]}
    assert names == {f"reference-time{end}": scenes for end, scenes in expected.items()}


def test_levels_and_parts_of_every_scene() -> None:
    table = reference_mesh.convergence_table(stored())
    assert [r["scene"] for r in table.rows] == list(stored())
    assert sum(int(row["levels"] or 0) > 1 for row in table.rows) >= 9
    for row in table.rows:
        parts = [float(row[key] or 0.0) for key in ("contact", "bodies", "sockets", "common")]
        assert row["bar"] == pytest.approx(2.0 * np.linalg.norm(parts))
    levels = reference_mesh.level_table(STUDY, stored())
    for name, found in stored().items():
        of_scene = [r for r in levels.rows if r["scene"] == name and r["level"] != "source"]
        assert [r["change"] is None for r in of_scene] == [False] * (len(found.runs) - 1) + [True]
    assert set(NAMES) >= {f"3D level {k}" for k in LEVELS}
