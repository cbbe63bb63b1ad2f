"""Tests that kill one-line mutants which once survived all others; tests/mutants/run.py tries the whole list."""

from __future__ import annotations

import ast
import builtins
import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from subprocess import TimeoutExpired
from types import SimpleNamespace

import numpy as np
import pytest
from tests.helpers import small_screw
from tests.mutants import draw

from rollbench.comparison.gate import closed_forms
from rollbench.comparison.scenes.catalogue import scene as shipped
from rollbench.comparison.scenes.catalogue import shipped as any_shipped
from rollbench.comparison.wings.members.ensemble import ENGINE, run_ensemble, work_of
from rollbench.comparison.wings.rolling import runs
from rollbench.comparison.wings.rolling.changes import PATHS
from rollbench.hifi.rolling import friction
from rollbench.lowfi.friction.whole.state import FrictionState
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout, layout_at
from rollbench.meshes.partition import beam_nodes, contact_stations
from rollbench.meshes.parts import Load, Support
from rollbench.meshes.sockets import groove_lines, track_gaps

ROOT = Path(__file__).parents[2]
MUTANTS = tomllib.loads((Path(__file__).parent / "mutants.toml").read_text(encoding="utf-8"))["mutant"]


def test_marks_by_which_kernels_are_tried_are_known():
    settings = tomllib.loads((draw.ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    known = {re.split(r"\W", line)[0] for line in settings["tool"]["pytest"]["ini_options"]["markers"]}
    assert set(re.findall(r"\w+", draw.SHORT[1])) <= known | {"not", "and"}


def test_reactions_turn_the_screw_about_the_origin():
    """Two supports beside each other, none at the origin: their forces have moments."""
    scene = small_screw(9, 1.5, oversize=3e-6)
    held = tuple((name, 0.0) for name in ("ux", "uy", "rz"))
    loads = (Load(0.12, (200.0, 50.0, 500.0), (0.0, 0.0, 0.0)),)
    result = solve_static(replace(scene, supports=(Support(0.05, held), Support(0.19, held[:2])), loads=loads))
    balance = result.equilibrium
    assert np.abs(balance.reaction_moment).max() > 0.5
    total = balance.applied_moment + balance.reaction_moment + balance.contact_moment + balance.pin_moment
    assert np.abs(total).max() < 1e-8 * np.abs(balance.reaction_moment).max()


def test_textbook_formulas_agree_to_round_off():
    for name, _, computed, closed in closed_forms.sphere_on_flat(shipped("lin-case1"), 200.0):
        assert computed == pytest.approx(closed, rel=1e-9), name
    assert np.divide(*closed_forms.preload(shipped("lin-case1"), 5e-6)) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("at", [0.06, 0.06 + 6e-6])
def test_stations_a_few_micrometres_apart_bend_as_one_force(at):
    """A load and a support within a node's width of others: moments balance about the load's and support's own stations."""
    scene = small_screw(9, 1.5, oversize=3e-6)
    contact = float(contact_stations(scene, ball_layout(scene))[3, 0])
    held = tuple((name, 0.0) for name in ("ux", "uy", "uz", "rz"))
    supports = (Support(contact + 6e-6, held), Support(at, held[:2]))
    loads = (Load(0.06 + 3e-6, (200.0, 50.0, 500.0), (0.0, 0.0, 0.0)),)
    result = solve_static(replace(scene, supports=supports, loads=loads))
    assert result.converged, result.status
    assert result.equilibrium.moment_residual < 1e-10
    nodes = beam_nodes(scene, np.array([contact]))[0]
    assert contact + 6e-6 not in nodes
    assert contact + 6e-6 in beam_nodes(replace(scene, supports=supports), np.array([contact]))[0]


@pytest.mark.parametrize("hand", ["right", "left"])
def test_the_tangent_is_the_direction_of_the_path(hand):
    track = small_screw(8, 1.6, hand=hand).track
    azimuth, step = np.array([0.3, 2.0, 4.5]), 1e-6
    pitch = (1.0 if hand == "right" else -1.0) * track.lead / (2.0 * np.pi)

    def path(a):
        return np.stack([track.pitch_radius * np.cos(a), track.pitch_radius * np.sin(a), pitch * a], axis=-1)

    along = (path(azimuth + step) - path(azimuth - step)) / (2.0 * step)
    found = layout_at(track, azimuth, pitch * azimuth).tangent
    assert found == pytest.approx(along / np.linalg.norm(along, axis=-1, keepdims=True), abs=1e-9)


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("starts", [1, 2, 3])
def test_balls_of_every_start_lie_on_its_groove_line(hand, starts):
    scene = small_screw(8, 1.6, hand=hand)
    scene = replace(scene, track=replace(scene.track, starts=starts, lead=starts * 20e-3))
    m, layout = GrooveMap.of(scene), ball_layout(scene)
    lines, pitch = np.array(groove_lines(m)), 2.0 * np.pi * abs(m.rg)
    off = ((layout.z - m.rg * layout.azimuth)[:, None] - lines[None, :]) / pitch
    near = np.abs(off - np.round(off))
    assert near.min(axis=1).max() < 1e-9
    assert set(near.argmin(axis=1).tolist()) == set(range(starts))


@pytest.mark.parametrize("hand", ["right", "left"])
def test_gaps_do_not_depend_on_whole_turns_of_azimuths(hand):
    scene = small_screw(12, 2.3, hand=hand)
    m, layout = GrooveMap.of(scene), ball_layout(scene)
    straight = track_gaps(m, layout.azimuth, layout.z)
    wrapped = track_gaps(m, np.mod(layout.azimuth, 2.0 * np.pi), layout.z)
    assert np.sort(wrapped[0]) == pytest.approx(np.sort(straight[0]))
    assert sorted(map(sorted, wrapped[1].tolist())) == sorted(map(sorted, straight[1].tolist()))


def test_the_limit_of_rigid_bodies_is_the_mean_of_its_quadratures_and_their_distance_its_spread(monkeypatch):
    state = SimpleNamespace(
        converged=True, status="converged", upwind=0.0, power=1.0, residual=0.0, seconds=0.0, contacts=()
    )
    monkeypatch.setattr(runs.balls, "solve_rolling", lambda *_: state)
    monkeypatch.setattr(runs.balls, "solve_rigid_rolling", lambda _, quadrature, **__: quadrature)
    monkeypatch.setattr(runs, "measures", lambda _, apart, __: {"force 1-2 N": 1.0 if apart is state else float(apart)})
    run = runs.compute(any_shipped("lin-pair-a"), 1)
    ends = sorted(runs.QUADRATURES)
    assert run.limit["force 1-2 N"] == pytest.approx(0.5 * (ends[0] + ends[1]), rel=1e-12)
    assert run.limit_spread["force 1-2 N"] == ends[1] - ends[0]


def test_the_path_by_threes_falls_by_threes_as_far_as_any():
    path = np.array(PATHS["by threes"])
    np.testing.assert_allclose(path[:-1] / path[1:], 3.0, rtol=1e-12)
    assert path[-1] <= friction.PATH[-1]


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda m: m["name"])
def test_mutants_are_of_the_present_sources(mutant):
    """A list that no longer fits the sources would try nothing."""
    assert (ROOT / mutant["file"]).read_text(encoding="utf-8").count(mutant["old"]) == 1
    assert mutant["old"] != mutant["new"]
    assert mutant.get("equivalent") or all((ROOT / test.split("::")[0]).exists() for test in mutant["tests"])


def test_drawn_mutants_are_sources_that_differ_in_one_place():
    drawn = list(draw.draw(1, 6))
    assert drawn == list(draw.draw(1, 6))
    assert len({mutant.path for mutant in drawn}) == len(drawn) > 3
    assert any("kernel" in path.parts for path in draw.modules())
    for mutant in drawn:
        text = mutant.path.read_text(encoding="utf-8")
        changed = text[: mutant.low] + mutant.new + text[mutant.high :]
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))
        assert all((ROOT / test.partition("::")[0]).exists() for test in draw.nearest(mutant.path))


@pytest.fixture
def own_record(tmp_path, monkeypatch):
    """A record of its own, and a copy that is none: nothing is run, and all live through the nearest tests."""
    monkeypatch.setattr(draw, "RECORD", tmp_path / "drawn.json")
    monkeypatch.setattr(draw, "copied", lambda folder: folder)
    monkeypatch.setattr(draw.Mutant, "survives_nearest", lambda *_: True)
    monkeypatch.setattr(draw, "reaching", lambda drawn, _: {mutant: [mutant.name] for mutant in drawn})


@pytest.mark.usefixtures("own_record")
def test_a_record_of_drawn_mutants_goes_on_and_tries_survivors_again(monkeypatch, capsys):
    names = [mutant.name for mutant in draw.draw(1, 6)]
    tried = []

    def survives(mutant, tests, _):
        assert tests == [mutant.name]
        tried.append(mutant.name)
        return mutant.name == names[0] and len(tried) <= len(names)

    monkeypatch.setattr(draw.Mutant, "survives", survives)
    assert draw.main(6, [1]) == 1
    assert tried == names
    draw.keep(1, draw.kept(1) | {names[1]: "equivalent: it changes no answer"})
    assert draw.main(6, [1]) == 0
    assert tried == [*names, names[0]]
    assert draw.kept(1)[names[0]] == "killed by a later test"
    before = (len(names) - 2) / (len(names) - 1)
    assert draw.rate(draw.kept(1).values()) == (before, 1.0)
    assert capsys.readouterr().out.endswith(f"{100 * before:.0f} % killed when drawn, 100 % today\n")


@pytest.mark.usefixtures("own_record")
def test_a_mutant_whose_tests_fail_without_it_ends_the_trial(monkeypatch, capsys):
    def survives(mutant, *_):
        raise RuntimeError(f"{mutant.name}: its tests fail without it")

    monkeypatch.setattr(draw.Mutant, "survives", survives)
    assert draw.main(6, [1]) == 2
    assert draw.kept(1) == {}
    assert "fail without it" in capsys.readouterr().err


def test_tests_that_evaluate_a_place_are_found_the_quickest_first(tmp_path, monkeypatch):
    module, copy = tmp_path / "tree/module.py", tmp_path / "copy"
    init = copy / ".import/rollbench/__init__.py"
    for path in (module, copy / "module.py"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("def f(x):\n    return 2 * (x + 1) if x > 3 else 0\n", encoding="utf-8")
    init.parent.mkdir(parents=True)
    init.write_text("from __future__ import annotations\n", encoding="utf-8")
    monkeypatch.setattr(draw, "ROOT", module.parent)
    monkeypatch.setattr(builtins, "_note", None, raising=False)
    drawn = [draw.Mutant(module, *place) for place in draw.mutants(module.read_text(encoding="utf-8"))]

    def pytest(_, folder, **environment):
        exec(init.read_text(encoding="utf-8"))
        names: dict = {}
        exec((folder / "module.py").read_text(encoding="utf-8"), names)
        monkeypatch.setenv("REACHED", environment["REACHED"])
        for test, x in {"slow[a b]@group": 4, "fails": 4, "quick": 5, "other": 1}.items():
            monkeypatch.setenv("PYTEST_CURRENT_TEST", f"tests/a.py::{test} (call)")
            assert names["f"](x) == (2 * (x + 1) if x > 3 else 0)
        said = (
            "0.50s call     tests/a.py::slow[a b]@group",
            "0.01s call     tests/a.py::quick",
            "FAILED tests/a.py::fails - x",
        )
        return SimpleNamespace(stdout="\n".join(said))

    monkeypatch.setattr(draw, "pytest", pytest)
    found = {module.read_text(encoding="utf-8")[m.start : m.end]: tests for m, tests in draw.reaching(drawn, copy).items()}
    both, other = ["tests/a.py::quick", "tests/a.py::slow[a b]"], ["tests/a.py::other"]
    assert found == dict.fromkeys(("2 * (x + 1)", "x + 1", "2", "1"), both) | {
        "0": other,
        "x > 3": other + both,
        "3": other + both,
    }
    assert (copy / "module.py").read_text(encoding="utf-8") == module.read_text(encoding="utf-8")


def test_kernels_are_tried_as_plain_python_and_their_machine_code_is_kept_apart(tmp_path, monkeypatch):
    path = next(path for path in draw.modules() if "kernel" in path.parts)
    mutant = draw.Mutant(path, *next(draw.mutants(path.read_text(encoding="utf-8"))))
    asked, answers = [], [True, True]
    copy = tmp_path / path.relative_to(ROOT)
    copy.parent.mkdir(parents=True)

    def passes(tests, *_, **environment):
        asked.append((set(environment), copy.read_text(encoding="utf-8") != path.read_text(encoding="utf-8")))
        return "--lf" not in tests and answers.pop(0)

    monkeypatch.setattr(draw, "passes", passes)
    monkeypatch.setattr(draw, "inside", lambda _: [])
    assert mutant.survives_nearest(tmp_path)
    assert asked == [({"NUMBA_DISABLE_JIT"}, True), ({"NUMBA_CACHE_DIR"}, True)]
    assert copy.read_text(encoding="utf-8") == path.read_text(encoding="utf-8")
    asked.clear()
    answers[:] = [False, False]
    with pytest.raises(RuntimeError, match="fail without it"):
        mutant.survives_nearest(tmp_path)
    with pytest.raises(RuntimeError, match="fail without it"):
        mutant.tried([], tmp_path, 1.0, NUMBA_CACHE_DIR="")
    plain, code = {"NUMBA_DISABLE_JIT"}, {"NUMBA_CACHE_DIR"}
    assert asked == [(plain, True), (plain, False), (code, True), (set(), False)]


def test_tests_that_take_too_long_with_and_without_a_mutant_give_no_verdict(tmp_path, monkeypatch):
    mutant = next(iter(draw.draw(1, 6)))
    copy = tmp_path / mutant.path.relative_to(ROOT)
    copy.parent.mkdir(parents=True)
    slow_without = [False]

    def passes(*_, **__):
        if slow_without[0] or copy.read_text(encoding="utf-8") != mutant.path.read_text(encoding="utf-8"):
            raise TimeoutExpired("pytest", 1.0)
        return True

    monkeypatch.setattr(draw, "passes", passes)
    assert not mutant.tried(["tests"], tmp_path, 1.0)
    slow_without[0] = True
    assert mutant.tried(["tests"], tmp_path, 1.0)


def test_the_kept_record_of_drawn_mutants_reaches_the_goal():
    every = json.loads(draw.RECORD.read_text(encoding="utf-8"))
    found = [word for own in every.values() for word in own.values()]
    assert len(found) >= 60
    assert set(found) - {"killed", "killed by a later test", "survives"} == {
        w for w in found if w.startswith("equivalent: ")
    }
    assert draw.rate(found)[1] >= draw.GOAL


def test_a_state_bears_load_however_small_it_is():
    loaded = [FrictionState.loaded.fget(SimpleNamespace(at=SimpleNamespace(force=np.array([[x]])))) for x in (0.0, 1e-9)]
    assert loaded == [False, True]


def test_members_that_no_batch_solves_say_their_residuals_and_works():
    scene = shipped("lin-random")
    actual = replace(scene, ingredients=replace(scene.ingredients, hertz="actual"))
    found = run_ensemble(actual, 2)
    for m in range(2):
        alone = solve_static(actual, engine=ENGINE, member=m)
        assert (found.residuals[m], found.works[m]) == (alone.solver.residual, work_of(actual, alone))
