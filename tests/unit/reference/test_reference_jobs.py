"""Jobs of the 3D reference: plan, what is missing, what is kept and told, levels of the command line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.reference_records import bodies_of, run_of

from rollbench.comparison.commands.comparing import study
from rollbench.comparison.commands.comparing.compare_output import levels_text
from rollbench.comparison.commands.comparing.study import code_of, parse_levels, unconverged
from rollbench.comparison.commands.reporting.report import compute_references
from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.verdict import Limits, judge
from rollbench.comparison.models import comparison
from rollbench.comparison.models.ladder import DEEP, UNSEEN
from rollbench.comparison.models.study import Study
from rollbench.comparison.models.total_uncertainty import total
from rollbench.comparison.reference import computing, jobs
from rollbench.comparison.reference.estimate import reference_of
from rollbench.comparison.reference.levels import LEVELS, STUDIED
from rollbench.comparison.reference.store import Run, bodies_path, load, path_in, save, shipped_store
from rollbench.comparison.reference.tasks import Task
from rollbench.comparison.reference.variants import VARIANTS
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.wings.mesh_study.command import run_mesh_study
from rollbench.meshes.condensed import CondensedBodies

CASE1 = catalogue.scene("lin-case1")


def run_at(level: int, load: float = 1.0) -> Run:
    """A run of case 1 with equal loads."""
    return run_of("lin-case1", level, np.full((32, 4), load))


def computes(monkeypatch: pytest.MonkeyPatch, result: Callable[[Task], object]) -> None:
    """Let tasks have this result in place of what would be computed."""
    monkeypatch.setattr(jobs, "compute_with_bodies", lambda task, _: result(task))


def ensured(tasks: list[Task], store: Path, step: Callable[[str], object] = lambda _: None, **options: object) -> list[Run]:
    return jobs.ensure(tasks, store, jobs.Engine(), step, **options)


def test_a_task_without_its_bodies_is_missing(tmp_path: Path) -> None:
    task, run = Task((CASE1,), 1), run_at(1)
    save(tmp_path, CASE1, run)
    assert jobs.missing([task], (tmp_path,)) == [task]
    jobs.keep(tmp_path, task, [run], bodies_of(CASE1, 1))
    assert jobs.missing([task], (tmp_path,)) == []


def test_a_run_of_several_sets_adds_up_what_they_took(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unknowns of every set, seconds of each set-up once however many share it, memory with that of the largest helpers."""
    monkeypatch.setattr(computing, "peak_MB", lambda: 100.0)
    monkeypatch.setattr(computing, "recorded", lambda _: {})

    def setup(helpers: float, quality: float) -> SimpleNamespace:
        found = dict.fromkeys(("screw", "nut", "ball"), quality)
        seconds, dims = {"meshes": 2.0, "bodies": 3.0}, SimpleNamespace(assumed=("a wall",))
        return SimpleNamespace(sides=(0, 3), seconds=seconds, others_MB=helpers, quality=found, dims=dims)

    one, two = setup(30.0, 0.4), setup(50.0, 0.3)
    arrays = {"load": np.ones((6, 4)), "contact_angle": np.full((6, 4), np.pi / 4.0), "frozen": np.ones((6, 4))}
    sums = {"seconds": 1.0, "status": "converged", "moving": 0.0, "balance": 0.0, "along_groove": 0.0, "screw_balance": 0.0}
    found = SimpleNamespace(**arrays, stations=np.zeros(4), centreline=np.zeros((4, 6)), unknowns=2500, **sums)
    assembly = SimpleNamespace(name="three")
    task = SimpleNamespace(level=1, variant="", ablate=False, single=(), scenes=(assembly,))
    run = computing._run(task, 0, assembly, found, (one, one, two), ())
    assert (run.unknowns, run.peak_MB) == (2500, 150.0)
    assert run.stages == {"meshes": 4.0, "bodies": 6.0}
    assert (run.load.shape, run.angle[0, 0], run.quality["ball"], run.assumed) == ((6, 4), 45.0, 0.3, ("a wall",))


def test_cores_are_divided_among_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "cores", lambda: 4)
    engines = [jobs.Engine(), jobs.Engine(workers=2), jobs.Engine(workers=5), jobs.Engine("dask")]
    assert [engine.processes for engine in engines] == [4, 2, 1, 1]


def test_plan_and_what_is_missing(tmp_path: Path) -> None:
    scenes = [CASE1, catalogue.scene("lin-case2")]
    tasks = jobs.plan(scenes, (1, 2), ("land",), ablate=True)
    planned = {(t.level, t.variant, t.ablate, len(t.scenes)) for t in tasks}
    assert planned == {(1, "", True, 2), (2, "", False, 2), (1, "land", False, 1)}
    assert [t.level for t in jobs.plan([CASE1], (1, 2, 3), source=True)] == [1, 3, 2, 0], "the coarsest level first"
    save(tmp_path, CASE1, run_at(2))
    save(tmp_path, scenes[1], replace(run_of("lin-case2", 1, np.ones((32, 4))), without={}))
    left = {(t.level, t.variant): [s.name for s in t.scenes] for t in jobs.missing(tasks, (tmp_path,))}
    assert left == {(1, ""): ["lin-case1", "lin-case2"], (2, ""): ["lin-case2"], (1, "land"): ["lin-case1"]}


def test_what_is_kept_is_told_while_more_is_to_come(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[tuple[int, bool]] = []
    computes(monkeypatch, lambda task: ([run_at(task.level)], None))

    def note(task: Task) -> None:
        heard.append((task.level, load(CASE1, task.level, stores=(tmp_path,)) is not None))

    ensured(jobs.plan([CASE1], (1, 2)), tmp_path, stored=note)
    assert heard == [(1, True)]


@pytest.mark.parametrize("command", ["compare", "mesh-study"])
def test_commands_print_the_coarsest_level_first(command: str, tmp_path: Path, monkeypatch, capsys) -> None:
    computes(monkeypatch, lambda task: ([load(CASE1, task.level, stores=(shipped_store(),))], None))
    engine = jobs.Engine()
    if command == "compare":
        study.run_compare(("lin-case1",), (), (1, 2), tmp_path, engine, fresh=True)
    else:
        run_mesh_study(("lin-case1",), 2, tmp_path, engine, fresh=True, spread=False, source=False)
    said = capsys.readouterr().err
    assert said.index("[1/2] lin-case1: level 1") < said.index("lin-case1, by level 1 alone:") < said.index("[2/2]")
    assert {"compare": "refined is off by", "mesh-study": "largest load, SL"}[command] in said


def test_each_job_is_stored_when_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []

    def result(task: Task) -> tuple[list[Run], CondensedBodies]:
        if task.level == 2:
            raise KeyboardInterrupt
        return [run_at(task.level)], bodies_of(CASE1, task.level)

    computes(monkeypatch, result)
    tasks = [Task((CASE1,), level) for level in (1, 2)]
    with pytest.raises(KeyboardInterrupt):
        ensured(tasks, tmp_path, said.append)
    kept = {path(tmp_path, CASE1, run_at(1)).name for path in (path_in, bodies_path)}
    assert {p.name for p in tmp_path.iterdir()} == kept
    assert jobs.missing(tasks, (tmp_path,)) == [tasks[1]]
    assert any("[1/2]" in line and "s left" in line for line in said)


def test_a_run_that_did_not_converge_is_told_and_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said, task = list[str](), Task((CASE1,), 1)
    reason = "a contact reaches the rim of its patch: it needs 1.6 mm,\nhas 1.5 mm"
    computes(monkeypatch, lambda _: ([replace(run_at(1), status=reason)], None))
    found = ensured([task], tmp_path, said.append)
    assert [run.status for run in found] == [reason]
    assert list(tmp_path.iterdir()) == []
    assert all("\n" not in line for line in said)
    assert any("it needs 1.6 mm, has 1.5 mm" in line for line in said)
    assert jobs.missing([task], (tmp_path,)) == [task]
    words = str(unconverged("lin-case1", found))
    assert "level 1: a contact reaches the rim of its patch: it needs 1.6 mm, has 1.5 mm" in words
    assert "\n" not in words


def test_a_run_that_did_not_settle_is_kept_with_what_it_may_move_by(tmp_path: Path, monkeypatch) -> None:
    said, status = list[str](), "not settled: loads may still move by 0.5 N after 30 updates of directions and gaps"
    first, good = run_at(1, 99.0), run_at(2, 100.0)
    computes(monkeypatch, lambda _: ([replace(first, status=status, moving=0.5)], None))
    assert ensured([Task((CASE1,), 1)], tmp_path, said.append) == []
    assert any(status in line and "not stored" not in line for line in said)
    kept = load(CASE1, 1, stores=(tmp_path,))
    assert (kept.status, kept.moving) == (status, 0.5)
    moved = replace(good, status=status, moving=0.5)
    alone, settled, found = (reference_of("lin-case1", CASE1, runs) for runs in ((kept,), (first, good), (first, moved)))
    assert alone.unsettled == f"level 1 {status}"
    assert (alone.uncertainty >= 0.5).all()
    assert settled.unsettled == ""
    np.testing.assert_allclose(found.uncertainty, settled.uncertainty + 0.5)
    assert (code_of([settled]), code_of([settled, found])) == (0, 5)
    assert status in levels_text(found, total(CASE1, found))
    limit = 1.0 + float(settled.uncertainty.max()) + 0.2
    before, after = (judge("mine", np.full((32, 4), 101.0), r, Limits(limit))[0] for r in (settled, found))
    assert (before.word, after.word) == ("pass", "undecided")
    assert status in after.detail


def test_fresh_computes_what_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task = Task((CASE1,), 1)
    jobs.keep(tmp_path, task, [run_at(1)], bodies_of(CASE1, 1))
    computes(monkeypatch, lambda _: ([run_at(1, 2.0)], bodies_of(CASE1, 1)))
    for fresh, found in ((False, 1.0), (True, 2.0)):
        ensured([task], tmp_path, fresh=fresh)
        assert load(CASE1, 1, stores=(tmp_path,)).load.max() == found


def test_levels_of_the_command_line() -> None:
    levels = {"3": (1, 2, 3), "1": (1,), "1,3": (1, 3), "source, 2": (0, 2)}
    assert {text: parse_levels(text) for text in levels} == levels
    for text in ("6", "0", "", "fine", "1;2"):
        with pytest.raises(InputError, match="--levels"):
            parse_levels(text)


def test_what_a_report_computes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[Task]] = []
    monkeypatch.setattr(jobs, "ensure", lambda tasks, *_, **_named: asked.append(list(tasks)))
    for made in (Study((tmp_path,)), Study((tmp_path,), quick=True), Study(None)):
        compute_references(made, jobs.Engine(), print)
    full, quick = asked
    assert {t.level for t in full if not t.variant} == {0, *LEVELS}
    assert {t.variant for t in full} == {"", *VARIANTS}
    cases = [t for t in full if t.scenes[0].name in comparison.REFERENCED]
    assert [t.ablate for t in cases if t.level == 1 and not t.variant] == [True]
    unseen = {(t.level, s.name) for t in full for s in t.scenes if s.name in UNSEEN}
    assert unseen == {(k, n) for n in UNSEEN for k in (*STUDIED, *([max(LEVELS)] if n in DEEP else []))}
    assert {s.name for t in full for s in t.scenes if t.level == max(LEVELS)} == set(DEEP)
    assert [(t.level, [s.name for s in t.scenes]) for t in quick] == [(1, ["lin-case1", "lin-case2"])]
