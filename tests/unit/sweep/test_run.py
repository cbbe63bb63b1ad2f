"""A sweep that is killed goes on without losing or repeating a sample; workers of any kind give the same numbers."""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from math import tau

import numpy as np
import pytest
from tests.load_cases import case
from tests.processes import python

from rollbench.compare.errors import InputError
from rollbench.compare.models import many
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies import columns
from rollbench.compare.studies.sweep import run as sweeping
from rollbench.compare.studies.sweep import sample
from rollbench.compare.studies.sweep.run import solve_sweep, sweep_definition
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.meshes.parts import SIDES, Load, Motion

VARY = ("supports[0].displace.ux=2 um:5 um", "errors.balls.oversize=4 um:7 um")
SCENE = "two-balls"
QUIET = ModelOptions(estimate_beam_mesh_error=False)


KILLS = """
import os, random, signal, sys, time
from pathlib import Path
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.models import many
from rollbench.compare.studies.sweep import run as sweeping
folder, kills, workers = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
sweeping.LARGEST_BATCH = 4  # workers are in the midst of theirs when their run is killed
what = sweeping.sweep_definition({scene!r}, {vary!r}, {samples}, "lhs", 1, "lin")
random.seed(5)
def lines():
    return 4 * sum(path.read_bytes().count(b"\\n") for path in (folder / many.RECORDS).glob("*.lines"))
killed = before = 0
while killed < kills and before < 0.7 * {samples}:  # at a random number of stored samples and a random moment after
    child = os.fork()
    if child == 0:
        sweeping.solve_missing_samples(what, folder, ComputingSettings(parallel_jobs=workers), print)
        os._exit(0)
    until = before + random.uniform(0.0, 0.8 * {samples} / (kills + 2))
    while lines() < min(until, {samples}):
        time.sleep(0.002)
    time.sleep(random.uniform(0.0, 0.005))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    killed, last, before = killed + 1, before, 4 * len(list(many.stored_rows(folder)))
    assert before >= last, (before, last)
assert before < {samples} and killed >= (kills + 1) // 2, (before, killed)  # however fast the machine
sweeping.solve_missing_samples(what, folder, ComputingSettings(parallel_jobs=workers), print)
"""


def stored(folder):
    """Records of all stored samples, row by row."""
    return [record for _, read in many.stored_rows(folder) for record in read()]


def solved(folder, sweep):
    """Records of a sweep, and what it said."""
    said = []
    return sweeping.solve_missing_samples(sweep, folder, ComputingSettings(), said.append), said


def run(folder, samples=40, seed=1):
    return solved(folder, sweep_definition(SCENE, VARY, samples, "lhs", seed, "lin"))


def sample_of(name, *wanted):
    """The outputs of a shipped scene as it is."""
    return sample.solve_samples(sample.VariedScene(*catalogue.scene_text_and_file_name(name), ()), [()], "lin", *wanted)[0]


def solution_of(name):
    """The scene, and the model's result."""
    scene = catalogue.scene_of_any_kind(name)
    return scene, run_model(scene, "lin", QUIET)


def killed(folder, kills, workers, samples):
    """Kill a sweep again and again, then let it end; workers that outlive their run are ended with the test."""
    script = KILLS.format(scene=SCENE, vary=VARY, samples=samples)
    arguments = [sys.executable, "-c", script, str(folder), str(kills), str(workers)]
    with (folder.parent / "said").open("w+") as said:
        process = subprocess.Popen(arguments, stdout=said, stderr=said, start_new_session=True)
        try:
            code = process.wait(200)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        said.seek(0)
        assert code == 0, said.read()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Records of a sweep of 200 samples that nobody kills."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweeping, "LARGEST_BATCH", 4)  # as in `KILLS`
        found, _ = run(tmp_path_factory.mktemp("undisturbed") / "a", 200)
    assert all(record["status"] == "converged" for record in found.values())
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("kills", "workers"), [(20, 1), (1, 2)], ids=["twenty kills", "workers that outlive the run"])
def test_a_killed_sweep_loses_and_repeats_nothing(kills, workers, tmp_path, undisturbed):
    killed(tmp_path / "a", kills, workers, 200)
    records = sorted(stored(tmp_path / "a"), key=lambda record: record["sample"])
    assert records == [undisturbed[number] for number in range(200)]


def test_what_is_stored_is_not_solved_again_but_torn_and_damaged_lines_are(tmp_path, monkeypatch):
    first, _ = run(tmp_path / "a")
    with monkeypatch.context() as patch:
        patch.setattr(sample, "solve_samples", None)
        again, said = run(tmp_path / "a")
    assert (again, "20 stored" in said[0]) == (first, True)
    (path,) = (tmp_path / "a" / "records").glob("*.lines")
    lines = path.read_bytes().splitlines(keepends=True)
    lines[3] = lines[3].replace(b"converged", b"convergeD")
    path.write_bytes(b"".join(lines)[:-7])
    assert len(stored(tmp_path / "a")) == 36
    again, said = run(tmp_path / "a")
    assert (again, "2 to solve" in said[0]) == (first, True)


def test_a_folder_of_another_sweep_or_in_use_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(many, "PATIENCE", 0.05)
    run(tmp_path / "a")
    header = json.loads((tmp_path / "a" / many.HEADER).read_text())
    with many.open_store(tmp_path / "a", header), pytest.raises(InputError, match="a computation that is running"):
        run(tmp_path / "a")
    earlier = many.Store(tmp_path / "a", "")
    with earlier.process_lock(), pytest.raises(InputError, match="processes of an earlier run"):
        run(tmp_path / "a")
    run(tmp_path / "a")
    assert list((tmp_path / "a" / many.LOCKS).iterdir()) == []
    with pytest.raises(InputError, match="another computation"):
        run(tmp_path / "a", seed=2)
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").touch()
    with pytest.raises(InputError, match="other files"):
        run(tmp_path / "b")


def test_failures_are_rows_with_their_reason_and_one_failure_a_reason(tmp_path):
    sweep = sweep_definition("lin-case1", ["balls.radius=2.7 mm:3.4 mm"], 6, "grid", 0, "lin")
    assert solve_sweep(sweep, tmp_path / "a", ComputingSettings(), print).converged
    found = {record["sample"]: record for record in stored(tmp_path / "a")}
    assert (found[0]["status"], found[5]["status"][:25]) == ("converged", "refused: lin-case1.toml: ")
    lines = (tmp_path / "a" / "samples.csv").read_text().splitlines()
    assert (len(lines), "refused" in lines[-1]) == (7, True)
    summary = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert summary["solved"] == 6 > summary["converged"] > 0
    failed, reasons = 6 - summary["converged"], summary["failures"]
    assert failed > len(reasons) >= 1
    assert sum(row["samples"] for row in reasons) == failed
    assert (tmp_path / "a" / "sweep-effects.svg").exists()


@pytest.mark.parametrize("samples", [4, 40])
def test_a_sweep_whose_first_samples_are_all_refused_for_one_reason_stops(tmp_path, samples):
    sweep = sweep_definition("lin-case1", ["balls.radius=3.3 mm:3.4 mm"], samples, "lhs", 0, "lin")
    words = r"were refused for the same reason; message for the last of them: lin-case1\.toml: .*allowed"
    with pytest.raises(InputError, match=words):
        solved(tmp_path / "a", sweep)
    assert not (tmp_path / "a").exists(), "the folder is free for the next one"


def test_rigidity_preload_torque_life_and_mean_load_are_those_of_solve_and_friction():
    found, (scene, result) = sample_of("lin-case3"), solution_of("lin-case3")
    answers = solve_with_results(scene, "lin", QUIET).only
    assert found["rigidity_N_per_um"] == pytest.approx(1e-6 * answers.rigidities.with_unequal_loads, rel=1e-9)
    assert found["preload_N"] == pytest.approx(answers.preload.axial, rel=1e-9)
    assert found["life_million_revolutions"] == pytest.approx(answers.life.revolutions, rel=1e-9)
    state = friction_state(scene, result, scene.friction, Motion(tau))
    assert found["torque_Nmm"] == pytest.approx(1e3 * state.friction_sums.friction_torque, rel=1e-6)
    assert sample_of("two-balls")["torque_Nmm"] is None, "no coefficient in the scene"
    found, (_, result) = sample_of("lin-pitch-2p1"), solution_of("lin-pitch-2p1")
    assert found["mean_load_N"] == pytest.approx(result.load.sum() / 64, rel=1e-12), "errors load 76 contacts"


def test_several_sets_have_the_same_outputs():
    found, (assembly, _) = sample_of("double-nut"), solution_of("double-nut")
    answers = solve_with_results(assembly, "lin", ModelOptions())
    assert found["rigidity_N_per_um"] == pytest.approx(1e-6 * answers.nut.secant, rel=1e-6)
    assert found["preload_N"] == pytest.approx(max(abs(s.preload.axial) for s in answers.sets.values()), rel=1e-6)
    shortest = min(s.life.revolutions for s in answers.sets.values())
    assert found["life_million_revolutions"] == pytest.approx(shortest, rel=1e-6)
    assert found["torque_Nmm"] > 0.0
    idle = sample_of("double-nut", ["idle_balls"])
    assert set(idle) == {"status", "largest_load_N", "idle_balls", "at"}


def test_rows_of_rollers_have_loads():
    found, (_, result) = sample_of("smith-axis-taper"), solution_of("smith-axis-taper")
    loads = np.concatenate([s.roller_load for s in result.sets])
    assert found["loaded_contacts"] == 64
    assert (found["largest_load_N"], found["mean_load_N"]) == pytest.approx((loads.max(), loads.mean()), rel=1e-9)
    assert found["at"].startswith("right 1: roller ")
    assert found["largest_approach_um"] is None, "no ball"


GOOD = "track.lead=10 mm:20 mm"


@pytest.mark.parametrize("vary", ["track.led=1 mm:2 mm", "track.lead=1 kN:2 kN", "loads[3].force[2]=1 N:2 N", GOOD])
def test_what_the_scene_or_the_program_does_not_have_is_refused_before_anything_is_solved(tmp_path, vary):
    model, words = ("no such", "model: got") if vary == GOOD else ("lin", None)
    with pytest.raises(InputError, match=words):
        solved(tmp_path / "a", sweep_definition("lin-case1", [vary], 6, "lhs", 0, model))
    assert not (tmp_path / "a").exists()


def test_a_sample_is_the_solution_of_its_scene():
    vary = ["loads[0].force[2]=1 kN:5 kN", "errors.balls.oversize=0 um:9 um"]
    sweep = sweep_definition("lin-case3", vary, 6, "lhs", 0, "lin")
    (found,) = sample.solve_samples(sweep, [["3.0 kN", "5.0 um"]], "lin")
    text = sweep.text.replace("5 kN", "3 kN").replace("7 um", "5 um")
    result = run_model(scene_file.scene_from_text(text, "x.toml"), "lin", QUIET)
    assert found["largest_load_N"] == pytest.approx(result.load.max(), rel=1e-12)
    assert found["loaded_contacts"] == (result.load > 0.0).sum()
    assert found["displacement_um"] == pytest.approx(1e6 * result.centreline[0, 2], rel=1e-12)
    ball, side = found["at"].split()
    assert result.load[int(ball) - 1, SIDES.index(side)] == result.load.max()


def test_nothing_needs_what_only_unix_has(tmp_path):
    words = ["sweep", "two-balls", "--vary", "errors.balls.oversize=4 um:7 um", "--samples", "2", "--model", "lin"]
    program = f"""
import sys
sys.modules["fcntl"] = sys.modules["resource"] = None
import rollbench.compare.studies.crosscheck.study
from rollbench.compare.cli import main
main({[*words, "--out", str(tmp_path / "sweep")]!r})
"""
    done = python("-c", program)
    assert (done.returncode, "samples.csv" in done.stdout) == (0, True), done.stderr


def test_outputs_that_are_not_asked_for_are_not_computed(tmp_path, monkeypatch):
    every, _ = run(tmp_path / "every", 4)
    some = sweep_definition(SCENE, VARY, 4, "lhs", 1, "lin", ["life_million_revolutions", "displacement_um"])
    with monkeypatch.context() as patch:
        patch.setattr(columns.loading, "solve_with_scaled_loads", None)  # the unloaded solution is of rigidity and preload
        found, _ = solved(tmp_path / "some", some)
    kept = ("largest_load_N", "displacement_um", "life_million_revolutions", "at", "sample", "status", "values")
    assert found == {n: {name: every[n][name] for name in kept} for n in range(4)}
    assert solve_sweep(some, tmp_path / "some", ComputingSettings(), print).to_dict()["outputs"].keys() == {*kept[:3]}
    assert (tmp_path / "some" / "samples.csv").read_text().splitlines()[0].endswith(",".join(("status", *kept[:4])))
    with pytest.raises(InputError, match="another computation"):
        run(tmp_path / "some", 4)
    with pytest.raises(InputError, match="outputs: got loads; allowed: largest_load_N"):
        solved(tmp_path / "c", sweep_definition(SCENE, VARY, 4, "lhs", 1, "lin", ["loads"]))


def test_growth_is_each_sets_largest_load_over_that_of_the_first_case():
    wanted = ["largest_growth", "least_growth"]
    text = catalogue.shipped_scene_text("double-nut") + case("a", share=0.5) + case("b", "5 kN", share=0.5)
    (found,) = sample.solve_samples(sample.VariedScene(text, "my.toml", ()), [()], "lin", wanted)
    scene = catalogue.scene_of_any_kind("double-nut")
    low, high = (
        [s.loads.max() for s in run_model(replace(scene, loads=(Load(0.0, (0.0, 0.0, f)),)), "lin", ModelOptions()).sets]
        for f in (2e3, 5e3)
    )
    ratios = [max(a, b) / a for a, b in zip(low, high, strict=True)]
    assert [found[name] for name in wanted] == pytest.approx([max(ratios), min(ratios)], rel=1e-9)
    assert max(ratios) > 1.1
    alone = sample_of("double-nut", wanted)
    assert [alone[name] for name in wanted] == [None, None]
