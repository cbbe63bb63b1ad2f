"""Stored studies: found again after a changed comment, computed again after a changed formula, and checked by a report."""

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.models.stored_study import (
    FOLDER,
    RECOMPUTED,
    Sources,
    StoredStudies,
    Study,
    digest_of_inputs,
    digest_of_runs,
    largest_difference,
    source_path,
)
from rollbench.compare.models.study import SceneResultCache
from rollbench.reports.content import Picture

FORMULA = '"""Module."""\nfrom {package} import other\n\n\ndef f(x):\n    """Square."""\n    return x**2  # a comment\n'


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of two modules, the first of which imports the second."""
    folder = tmp_path / "study_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "own.py").write_text(FORMULA.format(package=folder.name))
    (folder / "other.py").write_text("g = 9.81\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield folder
    source_path.cache_clear()
    for name in [x for x in sys.modules if x.startswith(folder.name)]:
        del sys.modules[name]


def digest() -> str:
    return Sources([]).digest(["study_package.own"])


@pytest.mark.parametrize(
    ("file", "old", "new", "same"),
    [
        ("own.py", "a comment", "another one", True),
        ("own.py", '"""Square."""\n', '"""Power of two.\n\n    More words."""\n', True),
        ("own.py", "x**2", "x ** 2", True),
        ("own.py", "x**2", "x**3", False),
        ("own.py", "def f(x)", "def f(x, y=0)", False),
        ("other.py", "9.81", "9.82", False),
        ("__init__.py", "", "h = 1\n", False),
    ],
)
def test_a_formula_counts_and_a_comment_does_not(package, file, old, new, same):
    before, path = digest(), package / file
    path.write_text(path.read_text().replace(old, new, 1))
    assert (digest() == before) == same


CALLS: list[str] = []


def radius_of_balls(cache: SceneResultCache) -> float:
    CALLS.append("radius")
    return cache.built_in_scene("lin-case1").balls.radius


def two_numbers(cache: SceneResultCache) -> dict[str, object]:
    """Study of a test, which uses a value that other studies of the same cache use, too."""
    CALLS.append("study")
    return {"a": (1.0, np.array([cache.compute_once(radius_of_balls)]))}


STUDY = Study("a", (__name__,), two_numbers)


def cache_with(folder: Path, **how) -> SceneResultCache:
    CALLS.clear()
    return SceneResultCache(stored_studies=StoredStudies([folder], folder, **how))


def value(cache: SceneResultCache, study: Study = STUDY):
    return cache.stored_studies.value(cache, study)


def test_a_value_is_found_with_its_scenes_and_computed_again_where_something_changed(tmp_path, monkeypatch):
    cache = cache_with(tmp_path)
    first = value(cache)
    value(cache, replace(STUDY, name="b"))
    assert CALLS == ["study", "radius", "study"]
    for name in "ab":
        cache = cache_with(tmp_path)
        assert largest_difference(value(cache, replace(STUDY, name=name)), first) == 0.0
        assert not CALLS
        assert list(cache.used_scenes) == ["lin-case1"], "also of a value that another study had computed"
    (tmp_path / FOLDER / "b.npz").write_bytes(b"torn")
    value(cache_with(tmp_path), replace(STUDY, name="b"))
    assert CALLS[:1] == ["study"]
    monkeypatch.setattr("rollbench.compare.models.stored_study.digest_of_inputs", lambda: "other printed numbers")
    value(cache_with(tmp_path))
    assert CALLS[:1] == ["study"]
    value(cache_with(tmp_path))
    assert not CALLS


def test_the_seconds_of_a_study_are_those_that_it_takes_alone(tmp_path, monkeypatch):
    """Also where another study had computed a value that it uses twice: by them a report chooses what it computes again."""
    clock = [0.0]
    monkeypatch.setattr("rollbench.compare.models.study.process_time", lambda: clock[0])

    def busy(_: object) -> float:
        clock[0] += 5.0
        return 1.0

    def study_of_two(name: str) -> Study:
        return Study(name, (__name__,), lambda cache: [cache.compute_once(busy), cache.compute_once(busy)])

    cache = cache_with(tmp_path)
    for name in "abab":
        assert value(cache, study_of_two(name)) == [1.0, 1.0]
    assert cache.stored_studies.found == {"a": 5.0, "b": 5.0}


@pytest.mark.parametrize("name", ["scenes/double-nut.toml", "studies/campaign.json", "cases/lin/layout.toml"])
def test_data_of_the_package_move_studies(monkeypatch, name):
    before, real = digest_of_inputs(), Path.read_text
    other = "other = 1" if name.endswith(".toml") else '{"other": 1}'
    monkeypatch.setattr(Path, "read_text", lambda path, *how: other if path.match(name) else real(path, *how))
    digest_of_inputs.cache_clear()
    assert digest_of_inputs() != before
    digest_of_inputs.cache_clear()


def test_what_cannot_be_stored_is_said_and_returned(tmp_path, capsys):
    odd = object()
    assert value(cache_with(tmp_path), Study("odd", (__name__,), lambda _: odd)) is odd
    assert "WARNING: study odd: a value of type object cannot be stored" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_runs_of_a_scene_of_the_user_do_not_count_and_those_of_a_shipped_scene_do(tmp_path):
    before = digest_of_runs([tmp_path])
    (tmp_path / "my-screw-level1-0123456789abcdef.json").touch()
    assert digest_of_runs([tmp_path]) == before
    (tmp_path / "lin-case1-level1-0123456789abcdef.json").touch()
    assert digest_of_runs([tmp_path]) != before


def test_measured_run_times_move_only_what_shows_them(tmp_path):
    def computed_again(study):
        value(cache_with(tmp_path), study)
        return bool(CALLS)

    plain, timed = replace(STUDY, name="plain"), replace(STUDY, name="timed", shows_run_times=True)
    assert [computed_again(one) for one in (plain, timed, plain, timed)] == [True, True, False, False]
    (tmp_path / "run_times.json").write_text("{}")
    assert [computed_again(one) for one in (plain, timed, plain, timed)] == [False, True, False, False]


def test_a_wrong_stored_value_is_seen_by_the_recomputation(tmp_path, monkeypatch):
    with monkeypatch.context() as planted:
        planted.setattr(SceneResultCache, "built_in_scene", lambda *_: SimpleNamespace(balls=SimpleNamespace(radius=1.0)))
        value(cache_with(tmp_path))
    cache = cache_with(tmp_path)
    value(cache)
    assert cache.stored_studies.drawn("2026-01-01") == ["a"]
    cache = cache_with(tmp_path, compared=["a"])
    value(cache)
    (again,) = cache.stored_studies.recomputed
    assert again.name == "a"
    assert again.difference > 0.9
    assert not cache.stored_studies.agree
    assert str(cache.stored_studies).startswith("1 stored studies, drawn by the date, were computed again (a)")


def test_the_date_draws_studies_whose_time_together_is_limited(tmp_path):
    studies = StoredStudies([tmp_path], None)
    studies.found = {f"long-{k}": 0.9 * RECOMPUTED for k in range(9)} | {f"short-{k}": 0.02 for k in range(40)}
    one, other = studies.drawn("2026-01-01"), studies.drawn("2026-01-02")
    assert one == studies.drawn("2026-01-01") != other
    for drawn in (one, other):
        assert len(drawn) == 41
        assert sum(studies.found[name] for name in drawn) <= RECOMPUTED


@pytest.mark.parametrize(
    ("one", "other", "difference"),
    [
        ({"a": [1.0, None]}, {"a": [1.5, None]}, 1.0 / 3.0),
        ({"load": 1.0, "seconds": 2.0}, {"load": 1.0, "seconds": 3.0}, 0.0),
        ((1.0, "x"), (1.0, "y"), float("inf")),
        ([float("nan")], [float("nan")], 0.0),
        ([1.0], [1.0, 2.0], float("inf")),
        (np.array([2.0, 4.0]), np.array([2.0, 5.0]), 0.2),
        (True, False, 1.0),
        (Picture("a", "A", np.zeros(3, np.uint8)), Picture("a", "A", np.ones(3, np.uint8)), 0.0),
        (1e-13, 3e-14, 0.0),
        ("1.25 N in 3 rows", "1.26 N in 3 rows", 0.0),
        ("1.25 N in 3 rows", "1.28 N in 3 rows", 0.03 / 1.28),
        ("1.25 N", "1.25 um", float("inf")),
    ],
)
def test_the_largest_difference_of_two_values(one, other, difference):
    assert largest_difference(one, other) == pytest.approx(difference)
