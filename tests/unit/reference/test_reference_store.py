"""Stored runs of the 3D reference: keys, damage, the gate against them, rows, jobs."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from compare.commands.study import parse_levels, unconverged
from compare.errors import InputError
from compare.gate import gate
from compare.models import comparison
from compare.models.comparison import from_model, gate_points, reference_answers, rows
from compare.models.ladder import DEEP, UNSEEN
from compare.models.mesh_study import study_table
from compare.models.registry import MODELS
from compare.models.study import Study
from compare.reference import jobs, store
from compare.reference.estimate import Reference, reference
from compare.reference.grid_summary import summarise
from compare.reference.levels import LEVELS, STUDIED
from compare.reference.store import Run, bodies_path, key_of, load, path_in, save
from compare.reference.tasks import Task, geometry_of, groups, needed_sides, serves, settings_of
from compare.reference.variants import VARIANTS
from compare.scenes import catalogue
from meshes.condensed import CondensedBodies, geometry_digest, load_condensed
from meshes.parts import Scene
from meshes.solid import dimensions


def run_of(scene_name: str, level: int, load_: np.ndarray, variant: str = "", group: tuple[str, ...] = ()) -> Run:
    """A run as meshed together with the scenes of ``group``."""
    settings = asdict(settings_of([catalogue.scene(n) for n in (group or (scene_name,))], level, variant))
    return Run(
        scene=scene_name,
        level=level,
        variant=variant,
        status="converged",
        load=load_,
        angle=np.full(load_.shape, np.nan),
        frozen=load_,
        centreline=np.zeros((3, 4)),
        without={"elastic nut": load_},
        without_seconds={"elastic nut": 1.0},
        sides=(0, 3),
        unknowns=10,
        stages={"meshes": 1.0, "nut": 2.0},
        solve_seconds=0.5,
        peak_MB=5.0,
        balance=0.0,
        along_groove=0.0,
        screw_balance=0.0,
        quality={"elements across 2b": 6.0},
        settings=settings,
        assumed=("nothing",),
        versions={},
        date="2026-01-01",
    )


def test_round_trip_and_damage(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    loads = np.arange(128.0).reshape(32, 4)
    run = run_of("lin-case1", 2, loads)
    file = save(tmp_path, scene, run)
    assert file == path_in(tmp_path, scene, run)
    back = load(scene, 2, stores=(tmp_path,))
    assert back is not None
    assert np.array_equal(back.load, loads)
    assert np.array_equal(back.without["elastic nut"], loads)
    assert np.isnan(back.angle).all()
    assert back.setup_seconds == 3.0
    assert (back.sides, back.assumed, back.settings) == ((0, 3), ("nothing",), run.settings)
    assert load(scene, 1, stores=(tmp_path,)) is None
    whole = file.read_text()
    modes = LEVELS[2]["modes"]
    other = whole.replace(f'"modes":{modes}', f'"modes":{modes + 1}')
    assert other != whole
    for damaged in (whole[:100], whole.replace('"load":[[', '"load":[[1],['), "[]", "", other):
        file.write_text(damaged)
        assert load(scene, 2, stores=(tmp_path,)) is None
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


def test_key_follows_the_content_not_the_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything that a run's numbers depend on changes its key; names and remarks do not."""
    scene = catalogue.scene("lin-case1")
    mesh, sides = asdict(settings_of([scene], 1)), (0, 3)
    key = key_of(scene, "", mesh, sides)
    assert key_of(replace(scene, title="other", assumed=(), name="x"), "", mesh, sides) == key
    assert key_of(scene, "", mesh | {"cuts": list(mesh["cuts"]), "semi": list(mesh["semi"])}, [0, 3]) == key
    changed = [
        replace(scene, nut=replace(scene.nut, length=0.055)),
        replace(scene, solid=replace(scene.solid, shaft=0.03)),
        replace(scene, loads=()),
    ]
    found = [key_of(s, "", mesh, sides) for s in changed]
    found += [key_of(scene, "", asdict(settings_of([scene], 2)), sides), key_of(scene, "land", mesh, sides)]
    found += [key_of(scene, "", mesh, (0, 1, 2, 3)), key_of(scene, "", mesh | {"reach": (1e-3, 1e-4)}, sides)]
    monkeypatch.setattr(store, "versions", lambda: {"gmsh": "0", "scikit-fem": "0"})
    found.append(key_of(scene, "", mesh, sides))
    monkeypatch.undo()
    monkeypatch.setattr(store, "SCHEMA", -1)
    found.append(key_of(scene, "", mesh, sides))
    monkeypatch.undo()
    assumed = dimensions(scene)
    monkeypatch.setattr(store, "dimensions", lambda _: replace(assumed, hole=2.0 * assumed.hole))
    found.append(key_of(scene, "", mesh, sides))
    assert len({key, *found}) == 11


def test_only_converged_runs_are_stored(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    failed = replace(run_of("lin-case1", 1, np.ones((32, 4))), status="not held: because")
    with pytest.raises(ValueError, match="no reference: not held: because"):
        save(tmp_path, scene, failed)
    jobs.keep(tmp_path, Task((scene,), 1), [failed], None)
    assert list(tmp_path.iterdir()) == []


def test_a_run_meshed_with_other_scenes_serves_if_its_mesh_does(tmp_path: Path) -> None:
    scene, loads = catalogue.scene("lin-case1"), np.ones((32, 4))
    wide = run_of("lin-case1", 1, loads, group=("lin-case1", "lin-case2"))
    assert wide.settings["reach"] > run_of("lin-case1", 1, loads).settings["reach"]
    narrow = run_of("unseen-short-nut", 1, np.ones((24, 4)))
    save(tmp_path, scene, wide)
    assert load(scene, 1, stores=(tmp_path,)) is not None
    for name in ("semi", "reach"):  # too coarse cells, too small patches
        factor = 1.5 if name == "semi" else 0.5
        other = replace(wide, settings=wide.settings | {name: tuple(factor * x for x in wide.settings[name])})
        assert not serves(scene, 1, "", other.settings, other.sides)
    assert not serves(scene, 1, "", wide.settings, (0, 1, 2))
    assert not serves(scene, 1, "", wide.settings | {"modes": 24}, wide.sides)
    assert not serves(scene, 1, "", narrow.settings | {"reach": (1e-4, 1e-5)}, narrow.sides)


@pytest.mark.parametrize(
    ("name", "sides"),
    [
        ("lin-case1", (0, 3)),
        ("lin-case2", (0, 3)),
        ("lin-case3", (0, 1, 2, 3)),
        ("lin-profile", (0, 1, 2, 3)),
        ("unseen-25x5", (0, 1, 2, 3)),
        ("unseen-63x20", (0, 3)),
    ],
)
def test_sides_that_may_touch(name: str, sides: tuple[int, ...]) -> None:
    assert needed_sides(catalogue.scene(name)) == sides


def test_scenes_of_the_same_parts_share_a_set_up() -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "bearing-9", "lin-case3-offset", "lin-profile")]
    found = [[s.name for s in g] for g in groups(scenes)]
    assert found == [["lin-case1", "lin-case3-offset", "lin-profile"], ["bearing-9"]]
    assert geometry_of(scenes[0]) != geometry_of(replace(scenes[0], solid=replace(scenes[0].solid, nut="rigid")))


def bodies_of(scene: Scene, level: int, sides: tuple[int, ...] = (0, 3)) -> CondensedBodies:
    k = len(sides)
    eye = np.eye(scene.ball_count * k // 2)
    return CondensedBodies(
        geometry_digest(scene),
        level,
        np.array(sides, dtype=float),
        0.3,
        eye,
        eye,
        np.eye(k),
        np.ones((k, 2)),
        np.tile([100.0, 200.0], (k, 1)),
        np.full(k, 1e-7),
    )


def test_condensed_bodies_survive_the_file_and_refuse_a_foreign_one(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    made = bodies_of(scene, 2)
    made.save(tmp_path / "a.npz")
    read = load_condensed(tmp_path / "a.npz")
    assert (read.geometry, read.level, read.base) == (made.geometry, 2, 0.3)
    assert np.array_equal(read.screw, made.screw)
    (tmp_path / "b.npz").write_bytes((tmp_path / "a.npz").read_bytes()[:-200])
    with pytest.raises(ValueError, match="damaged"):
        load_condensed(tmp_path / "b.npz")
    np.savez(tmp_path / "c.npz", format=99)
    with pytest.raises(ValueError, match="format 99"):
        load_condensed(tmp_path / "c.npz")


def test_a_task_without_its_bodies_is_missing(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    task, run = Task((scene,), 1), run_of("lin-case1", 1, np.ones((32, 4)))
    save(tmp_path, scene, run)
    assert jobs.missing([task], (tmp_path,)) == [task]
    jobs.keep(tmp_path, task, [run], bodies_of(scene, 1))
    assert jobs.missing([task], (tmp_path,)) == []


def test_bodies_are_keyed_by_the_range_of_loads_that_they_were_made_for(tmp_path: Path) -> None:
    """A run under other loads has the same geometry, but its patches' own terms are sampled elsewhere."""
    scene = catalogue.scene("lin-case1")
    run = run_of("lin-case1", 1, np.ones((32, 4)))
    heavy = replace(scene, loads=(replace(scene.loads[0], force=(0.0, 0.0, 60e3)),))
    other = replace(run, settings=asdict(settings_of([heavy], 1)))
    assert bodies_path(tmp_path, scene, run) != bodies_path(tmp_path, heavy, other)
    assert bodies_path(tmp_path, scene, run) == bodies_path(tmp_path, replace(scene, name="x"), run)
    assert bodies_path(tmp_path, scene, run) != bodies_path(tmp_path, scene, replace(run, sides=(0, 1, 2, 3)))


def test_plan_and_what_is_missing(tmp_path: Path) -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "lin-case2")]
    tasks = jobs.plan(scenes, (1, 2), ("land",), ablate=True)
    assert {(t.level, t.variant, t.ablate, len(t.scenes)) for t in tasks} == {
        (1, "", True, 2),
        (2, "", False, 2),
        (1, "land", False, 1),
    }
    loads = np.ones((32, 4))
    save(tmp_path, scenes[0], run_of("lin-case1", 2, loads))
    save(tmp_path, scenes[1], replace(run_of("lin-case2", 1, loads), without={}))
    left = {(t.level, t.variant): [s.name for s in t.scenes] for t in jobs.missing(tasks, (tmp_path,))}
    assert left == {(1, ""): ["lin-case1", "lin-case2"], (2, ""): ["lin-case2"], (1, "land"): ["lin-case1"]}


def test_each_job_is_stored_when_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = [catalogue.scene("lin-case1")]
    said: list[str] = []

    def fake(task: Task, _: object) -> tuple[list[Run], CondensedBodies]:
        if task.level == 2:
            raise KeyboardInterrupt
        return [run_of("lin-case1", task.level, np.ones((32, 4)))], bodies_of(scenes[0], task.level)

    monkeypatch.setattr(jobs, "compute_with_bodies", fake)
    tasks = [Task((scenes[0],), level) for level in (1, 2)]
    with pytest.raises(KeyboardInterrupt):
        jobs.ensure(tasks, tmp_path, jobs.Engine(), said.append)
    run = run_of("lin-case1", 1, np.ones((32, 4)))
    kept = {path_in(tmp_path, scenes[0], run).name, bodies_path(tmp_path, scenes[0], run).name}
    assert {p.name for p in tmp_path.iterdir()} == kept
    assert jobs.missing(tasks, (tmp_path,)) == [tasks[1]]
    assert any("[1/2]" in line and "s left" in line for line in said)


def test_a_run_that_did_not_converge_is_told_and_computed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = catalogue.scene("lin-case1")
    said: list[str] = []
    reason = "a contact reaches the rim of its patch: it needs 1.6 mm,\nhas 1.5 mm"
    failed = replace(run_of("lin-case1", 1, np.ones((32, 4))), status=reason)
    monkeypatch.setattr(jobs, "compute_with_bodies", lambda *_: ([failed], None))
    found = jobs.ensure([Task((scene,), 1)], tmp_path, jobs.Engine(), said.append)
    assert [run.status for run in found] == [reason]
    assert list(tmp_path.iterdir()) == []
    assert all("\n" not in line for line in said)
    assert any("it needs 1.6 mm, has 1.5 mm" in line for line in said)
    assert len(jobs.missing([Task((scene,), 1)], (tmp_path,))) == 1
    words = str(unconverged("lin-case1", found))
    assert "level 1: a contact reaches the rim of its patch: it needs 1.6 mm, has 1.5 mm" in words
    assert "\n" not in words


def test_fresh_computes_what_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = catalogue.scene("lin-case1")
    task, old = Task((scene,), 1), run_of("lin-case1", 1, np.ones((32, 4)))
    jobs.keep(tmp_path, task, [old], bodies_of(scene, 1))
    fresh = run_of("lin-case1", 1, np.full((32, 4), 2.0))
    monkeypatch.setattr(jobs, "compute_with_bodies", lambda *_: ([fresh], bodies_of(scene, 1)))
    jobs.ensure([task], tmp_path, jobs.Engine(), lambda _: None)
    assert load(scene, 1, stores=(tmp_path,)).load.max() == 1.0
    jobs.ensure([task], tmp_path, jobs.Engine(), lambda _: None, fresh=True)
    assert load(scene, 1, stores=(tmp_path,)).load.max() == 2.0


@pytest.mark.parametrize(("text", "levels"), [("3", (1, 2, 3)), ("1", (1,)), ("1,3", (1, 3)), ("source, 2", (0, 2))])
def test_levels_of_the_command_line(text: str, levels: tuple[int, ...]) -> None:
    assert parse_levels(text) == levels


@pytest.mark.parametrize("text", ["6", "0", "", "fine", "1;2"])
def test_wrong_levels_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--levels"):
        parse_levels(text)


@pytest.mark.parametrize("name", comparison.REFERENCED)
def test_shipped_runs_are_converged_and_in_balance(name: str) -> None:
    found = _found(name)
    assert tuple(r.level for r in found.runs) == STUDIED
    for run in found.runs:
        assert run.status == "converged"
        assert max(run.balance, run.screw_balance) < 1e-8
        assert abs(run.along_groove) < 1e-3
        assert run.quality["elements across 2b"] > 3.0
    lead = np.cos(np.arctan(20.0 / (2.0 * np.pi * 16.5)))
    axial = np.nansum(np.sin(np.radians(found.best.angle[:, 0])) * found.load[:, 0])
    axial -= np.nansum(np.sin(np.radians(found.best.angle[:, 1])) * found.load[:, 1])
    assert axial * lead == pytest.approx(5000.0, rel=2e-3)


def test_gate_passes_and_a_stiffness_off_by_20_per_cent_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gate sees a low-order shaft, or a low-order contact, whose stiffness is off by 20 per cent."""
    assert [row.name for row in gate.reference_rows(Study(), 7.0) if not row.passed] == []
    import lowfi.statics.elastic_system
    import lowfi.statics.problem
    from meshes.section import BeamSection

    right = lowfi.statics.elastic_system.grooved_section

    def soft(geometry, screw):  # type: ignore[no-untyped-def]
        s = right(geometry, screw)
        return BeamSection(0.8 * s.EA, 0.8 * s.EI, 0.8 * s.GJ, 0.8 * s.kGA)

    with monkeypatch.context() as patch:
        patch.setattr(lowfi.statics.elastic_system, "grooved_section", soft)
        assert any(not row.passed for row in gate.reference_rows(Study(), 7.0))
    stiff = lowfi.statics.problem.hertz_C
    with monkeypatch.context() as patch:
        patch.setattr(lowfi.statics.problem, "hertz_C", lambda *parts: 0.8 * stiff(*parts))
        assert any(not row.passed for row in gate.reference_rows(Study(), 7.0))


def _found(name: str) -> Reference:
    found = reference(catalogue.scene(name))
    assert found is not None
    return found


def test_unnamed_exceedance_and_vanished_one_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    points = gate_points("lin-case1", _found("lin-case1"), 7.0, Study().solve("lin-case1").load)
    worst = max(points, key=lambda p: abs(p.error_percent) - p.uncertainty_percent)
    limit = abs(worst.error_percent) - worst.uncertainty_percent - 0.01
    known = comparison.known_exceedances()
    monkeypatch.setattr(gate, "known_exceedances", list)
    failed = [r for r in gate.source_rows(Study(), limit) if not r.passed]
    assert any(f"ball {worst.ball} {worst.side} is beyond the line and not named" in r.detail for r in failed)
    gone = comparison.Exceedance("lin-case1", 5, "SL", "no cause")
    monkeypatch.setattr(gate, "known_exceedances", lambda: [*known, gone])
    assert any("ball 5 SL is named and no longer" in r.detail for r in gate.source_rows(Study(), 7.0))


def test_rows_name_every_loaded_contact_and_carry_the_error_bar() -> None:
    scene = catalogue.scene("lin-case1")
    found = _found("lin-case1")
    own = rows(scene, from_model(MODELS["lin"], scene), found)
    loads = [r for r in own if r.quantity == "load"]
    assert len(loads) == 64
    assert all(r.reference_error is not None and 0.0 <= r.reference_error < 10.0 for r in loads)
    assert all(r.reference_error is not None for r in own), "every comparison carries the reference's error bar"
    angles = [r for r in own if r.quantity == "contact angle"]
    assert len(angles) == 64
    assert all(r.reference_error < 0.3 for r in angles)
    assert {r.unit for r in own} == {"N", "%", "deg", "um", ""}
    printed = {r.quantity: r.printed for r in own if r.printed is not None}
    assert sorted(printed.values()) == [1.34, 2.3, 5.38]
    assert set(own[0].as_json()) == {
        "scene",
        "quantity",
        "ball",
        "side",
        "unit",
        "printed",
        "model",
        "value",
        "reference",
        "reference_error",
        "error_percent",
        "seconds",
    }
    assert found.uncertainty is not None
    ends = [int(pick(found.load[:, 0])) for pick in (np.argmax, np.argmin)]
    share = sum(found.uncertainty[k, 0] / found.load[k, 0] for k in ends)
    ratio = next(r for r in own if r.quantity.startswith("largest over smallest"))
    assert ratio.reference_error == pytest.approx(comparison.load_ratio(found.load) * share)
    finest = next(a for a in reference_answers(found, None) if a.model == f"3D level {max(STUDIED)}")
    assert all(r.error_percent == 0.0 for r in rows(scene, finest, found) if r.quantity == "load")


def test_mesh_study_says_why_there_is_an_order_or_none() -> None:
    scene = catalogue.scene("lin-case1")
    table = study_table(scene, None)
    largest = next(row for row in table if row["quantity"] == "largest load, SL")
    levels = {f"level {k}" for k in STUDIED}
    assert levels | {"uncertainty", "kind"} <= set(largest)
    found = _found("lin-case1")
    for row in table:
        assert (row["order"] is None) != row["kind"].startswith("monotone, order")
        assert row["kind"].startswith(("monotone, order ", "not monotone", "order out of range (p ", "held (zero"))
        values = [row[k] for k in sorted(levels)]
        steps = np.diff(values)
        if row["kind"] == "not monotone":
            assert (steps > 0.0).any()
            assert (steps < 0.0).any()
    assert found.convergence is not None
    ball = next(row for row in table if row["quantity"] == "load of ball 5, NR")
    assert ball["uncertainty"] == found.convergence[4][3].uncertainty
    balls = {int(run.load[:, 0].argmax()) for run in found.runs}
    assert len(balls) == 1, "the largest load stays at one ball, whose uncertainty it has"
    assert largest["uncertainty"] == found.convergence[balls.pop()][0].uncertainty


def test_two_levels_give_a_band_and_one_none(tmp_path: Path) -> None:
    scene = catalogue.scene("lin-case1")
    coarse = np.full((32, 4), 100.0)
    coarse[:, 1:3] = 0.0
    finer = coarse.copy()
    finer[0, 0] += 2.0
    save(tmp_path, scene, run_of("lin-case1", 1, coarse))
    one = reference(scene, (tmp_path,))
    assert one is not None
    assert one.uncertainty is None
    assert summarise(one).largest is None
    save(tmp_path, scene, run_of("lin-case1", 2, finer))
    two = reference(scene, (tmp_path,))
    assert two is not None
    assert two.uncertainty is not None
    assert two.uncertainty[0, 0] == pytest.approx(6.0)
    assert np.array_equal(two.estimate, finer)
    assert summarise(two).largest == pytest.approx(6.0 / finer[finer > 0.0].mean() * 100.0)
    assert (summarise(two).ball, summarise(two).side) == (1, 0)


def test_levels_of_one_order_are_extrapolated(tmp_path: Path) -> None:
    """Any number of levels: contacts of a common order, their limits, and the summary of the scene."""
    scene = catalogue.scene("lin-case1")
    limit = np.linspace(100.0, 200.0, 128).reshape(32, 4)
    slope = np.linspace(-3.0, 4.0, 128).reshape(32, 4)
    for level in STUDIED:
        h = LEVELS[1]["b_over_h"] / LEVELS[level]["b_over_h"]
        save(tmp_path, scene, run_of("lin-case1", level, limit + slope * h**1.5))
    found = reference(scene, (tmp_path,))
    assert found is not None
    assert found.extrapolated == pytest.approx(limit, rel=1e-5)
    s = summarise(found)
    assert s.pooled is not None
    assert s.pooled.order == pytest.approx(1.5, abs=1e-3)
    last = (LEVELS[1]["b_over_h"] / LEVELS[max(STUDIED)]["b_over_h"]) ** 1.5
    assert s.largest == pytest.approx(1.25 * 4.0 * last / s.mean * 100.0, rel=1e-2)
    assert s.levels == len(STUDIED)


def test_what_a_report_computes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from compare.commands.report import Source, compute_references

    asked: list[list[Task]] = []
    monkeypatch.setattr(jobs, "ensure", lambda tasks, *_, **_named: asked.append(list(tasks)))
    for source in (
        Source((tmp_path,), jobs.Engine()),
        Source((tmp_path,), jobs.Engine(), quick=True),
        Source(None, jobs.Engine(), compute=False),
    ):
        compute_references(Study(), source, print)
    full, quick = asked
    assert {t.level for t in full if not t.variant} == {0, *LEVELS}
    assert {t.variant for t in full} == {"", *VARIANTS}
    cases = [t for t in full if t.scenes[0].name in comparison.REFERENCED]
    assert [t.ablate for t in cases if t.level == 1 and not t.variant] == [True]
    unseen = {(t.level, s.name) for t in full for s in t.scenes if s.name in UNSEEN}
    assert unseen == {(k, n) for n in UNSEEN for k in (*STUDIED, *([max(LEVELS)] if n in DEEP else []))}
    assert {s.name for t in full for s in t.scenes if t.level == max(LEVELS)} == set(DEEP)
    assert [(t.level, [s.name for s in t.scenes]) for t in quick] == [(1, ["lin-case1", "lin-case2"])]
