"""Rows of the releases: kept once, read off this report, drawn."""

from rollbench.comparison import __version__
from rollbench.comparison.models.registry import MODELS
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.wings.bench.costs.kept import HISTORY, NAMES, QUANTITIES, Release, added, load_releases, save_rows
from rollbench.comparison.wings.bench.sections import history
from rollbench.comparison.wings.bench.sections.reference_time import Largest, TimePoint, all_points

ONE = Release("0.1", "a day", "abc", {"error": {"lin": 6.0}, "cold": {"lin": None}}, "a remark")


def test_what_is_saved_is_read_and_a_release_is_not_rewritten(tmp_path):
    assert load_releases([tmp_path]) == ()
    save_rows(tmp_path, HISTORY, (ONE,))
    assert load_releases([tmp_path / "none", tmp_path]) == (ONE,)
    other = Release("0.1", "later", "def", {})
    assert [added(rows, other) for rows in ((ONE,), ())] == [(ONE,), (other,)]


def test_the_package_has_rows_of_its_releases():
    rows = load_releases([shipped_store()])
    assert [row.version for row in rows][:2] == ["0.2.0", "0.3.0"]
    for row in rows:
        assert set(row.values) == set(QUANTITIES)
        assert len(row.commit.partition(",")[0]) == 40  # then, in words, that files were changed since
        assert {name for values in row.values.values() for name in values} <= set(NAMES)


def test_numbers_of_a_report_are_those_of_its_points():
    def point(label, error, cold, memory, kind="model"):
        return TimePoint(label, kind, error, 0.0, None, None, cold, None, 1, memory, label, Largest(error, error, error))

    lin, solid = MODELS["lin"].label, "3D reference, level"
    points = {
        "lin-case1": [point(lin, 6.0, 1.0, 90.0), point(f"{solid} 1", 0.3, 30.0, 900.0, "level")],
        "lin-case3": [point(lin, 9.0, 3.0, None), point(f"{solid} 1", 0.3, 50.0, 800.0, "level")],
        "unseen-thin-nut": [point(lin, 99.0, 99.0, 99.0)],
    }
    found = Study().references(("lin-case1", "lin-case3"))
    release = history.measured(points, found, "abc")
    assert (release.version, release.commit) == (__version__, "abc")
    assert [release.values["error"][model] for model in ("lin", "refined")] == [9.0, None]
    assert release.values["cold"] == {"refined": None, "lin": 2.0, "mei": None, "3D reference": 40.0}
    assert release.values["memory"] == {"refined": None, "lin": 90.0, "mei": None, "3D reference": 900.0}
    assert 0.0 < release.values["u"]["3D reference"] < 1.0
    table = history.history_table([("0.1", ONE), ("this report", release)])
    assert (len(table.rows), table.note) == (2 * len(QUANTITIES), "0.1: a remark")
    figure = history.history_figure([("0.1", ONE), ("this report", release)])
    assert [s.x for s in figure.panels[0].series if s.label == "lin"] == [[1.0, 2.0]]


def test_only_a_report_that_keeps_adds_a_release(tmp_path, monkeypatch):
    study = Study((tmp_path, shipped_store()))
    lin = TimePoint(MODELS["lin"].label, "model", 6.0, 2.0, None, None, 1.0, 0.1, 9, 90.0, "lin", Largest(6.0, 6.0, 6.0))
    level = TimePoint(
        "3D reference, level 4", "level", 0.0, 0.0, None, None, 90.0, 1.0, 9, 900.0, "3D level 4", Largest(0.0, 0.0, 0.0)
    )
    step = print
    study.computed[all_points, step] = {"lin-case1": [lin, level]}
    monkeypatch.setattr(history, "load_releases", lambda _: (ONE,))
    section = history.section(study, step)
    assert [row["release"] for row in section.items[1].rows][:: len(QUANTITIES)] == ["0.1", history.NOW]
    assert list(tmp_path.iterdir()) == []
    study.keeps = True
    history.section(study, step)
    assert [row.version for row in load_releases([tmp_path])] == ["0.1", __version__]
