"""A sweep that is killed goes on without losing or repeating a sample; workers of any kind give the same numbers."""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress

import pytest

from compare.commands.sweep import run_sweep, sweep_of
from compare.errors import InputError
from compare.models.registry import Options, run_model
from compare.reference.jobs import Engine
from compare.scenes import scene_file
from compare.sweep import run as sweeping
from compare.sweep import store
from compare.sweep.sample import solve_sample
from meshes.parts import SIDES

VARY = ("supports[0].displace.ux=2 um:5 um", "errors.balls.oversize=4 um:7 um")
SCENE = "two-balls"

KILLS = """
import os, random, signal, sys, time
from pathlib import Path
from compare.reference.jobs import Engine
from compare.scenes import catalogue
from compare.sweep import run as sweeping, store
from compare.sweep.keys import read_vary

folder, kills, workers = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
sweeping.BATCHES = 1  # so long that workers are in the midst of theirs when their run is killed
text, vary = catalogue.scene_text({scene!r}), read_vary({vary!r})
what = sweeping.Sweep(text, "{scene}.toml", vary, {samples}, "lhs", 1, "lin")
random.seed(5)
before = 0


def lines():
    return sum(path.read_bytes().count(b"\\n") for path in (folder / store.RECORDS).glob("*.lines"))


killed = 0
while killed < kills and before < 0.7 * {samples}:  # at a random number of stored samples and a random moment after
    child = os.fork()
    if child == 0:
        sweeping.run_samples(what, folder, Engine(workers=workers), print)
        os._exit(0)
    until = before + random.uniform(0.0, 0.8 * {samples} / (kills + 2))
    while lines() < min(until, {samples}):
        time.sleep(0.002)
    time.sleep(random.uniform(0.0, 0.005))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    killed += 1
    now = len(list(store.read(folder)))
    assert now >= before, (now, before)
    before = now
assert before < {samples} and killed >= (kills + 1) // 2, (before, killed)  # however fast the machine
sweeping.run_samples(what, folder, Engine(workers=workers), print)
"""


def what(samples=40, **other):
    return sweep_of(SCENE, VARY, samples, other.get("method", "lhs"), other.get("seed", 1), "lin")


def run(folder, samples=40, engine=None, **other):
    said = []
    return sweeping.run_samples(what(samples, **other), folder, engine or Engine(), said.append), said


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
    found, _ = run(tmp_path_factory.mktemp("undisturbed") / "a", 200)
    assert all(record["status"] == "converged" for record in found.values())
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("kills", "workers"), [(20, 1), (1, 2)], ids=["twenty kills", "workers that outlive the run"])
def test_a_killed_sweep_loses_and_repeats_nothing(kills, workers, tmp_path, undisturbed):
    killed(tmp_path / "a", kills, workers, 200)
    numbers = sorted(record["sample"] for record in store.read(tmp_path / "a"))
    assert numbers == list(range(200))
    assert store.load(tmp_path / "a") == undisturbed


def test_what_is_stored_is_not_solved_again(tmp_path, monkeypatch):
    first, _ = run(tmp_path / "a")
    monkeypatch.setattr("compare.sweep.sample.solve_sample", None)
    again, said = run(tmp_path / "a")
    assert again == first
    assert "40 stored" in said[0]


def test_torn_and_damaged_lines_are_solved_again(tmp_path):
    first, _ = run(tmp_path / "a")
    (path,) = (tmp_path / "a" / "records").glob("*.lines")
    lines = path.read_bytes().splitlines(keepends=True)
    lines[3] = lines[3].replace(b"converged", b"convergeD")
    path.write_bytes(b"".join(lines)[:-7])
    assert len(store.load(tmp_path / "a")) == 38
    again, said = run(tmp_path / "a")
    assert "2 to solve" in said[0]
    assert again == first


def test_a_folder_of_another_sweep_is_refused(tmp_path):
    run(tmp_path / "a")
    with pytest.raises(InputError, match="another sweep"):
        run(tmp_path / "a", seed=2)
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").touch()
    with pytest.raises(InputError, match="other files"):
        run(tmp_path / "b")


def test_a_folder_in_use_is_refused(tmp_path):
    run(tmp_path / "a")
    with store.taken_over(tmp_path / "a"), pytest.raises(InputError, match="under way"):
        run(tmp_path / "a")


def test_workers_that_do_not_see_the_folder_send_their_records_back(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "current", lambda *_: False)
    found, _ = run(tmp_path / "a")
    assert len(found) == 40


def test_failures_are_rows_with_their_reason(tmp_path):
    sweep = sweep_of("lin-case1", ["balls.radius=2.7 mm:3.4 mm"], 6, "grid", 0, "lin")
    found = sweeping.run_samples(sweep, tmp_path / "a", Engine(), print)
    status = [found[n]["status"] for n in range(6)]
    assert status[0] == "converged"
    assert status[-1].startswith("refused: lin-case1.toml: ")
    code = run_sweep(sweep, tmp_path / "a", Engine(), json_out=True, show=print, print_json=print)
    assert code == 0
    lines = (tmp_path / "a" / "samples.csv").read_text().splitlines()
    assert len(lines) == 7
    assert "refused" in lines[-1]
    text = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert text["solved"] == 6
    assert 0 < text["converged"] < 6
    assert (tmp_path / "a" / "sweep-effects.svg").exists()


def test_a_key_that_the_scene_does_not_have_is_refused_before_anything_is_solved(tmp_path):
    for vary in ("track.led=1 mm:2 mm", "track.lead=1 kN:2 kN", "loads[3].force[2]=1 N:2 N"):
        sweep = sweep_of("lin-case1", [vary], 6, "lhs", 0, "lin")
        with pytest.raises(InputError):
            sweeping.run_samples(sweep, tmp_path / "a", Engine(), print)
    assert not (tmp_path / "a").exists()


def test_an_unknown_model_is_refused(tmp_path):
    sweep = sweep_of("lin-case1", ["track.lead=10 mm:20 mm"], 6, "lhs", 0, "no such")
    with pytest.raises(InputError, match="--model"):
        sweeping.run_samples(sweep, tmp_path / "a", Engine(), print)


def test_a_sample_is_the_solution_of_its_scene():
    sweep = sweep_of("lin-case3", ["loads[0].force[2]=1 kN:5 kN", "errors.balls.oversize=0 um:9 um"], 6, "lhs", 0, "lin")
    found = solve_sample(sweep.text, sweep.origin, sweep.keys, ["3.0 kN", "5.0 um"], "lin", "interpreted")
    text = sweep.text.replace("5 kN", "3 kN").replace("7 um", "5 um")
    result = run_model(scene_file.loads(text, "x.toml"), "lin", Options(discretisation=False))
    assert found["largest_load_N"] == pytest.approx(result.load.max(), rel=1e-12)
    assert found["loaded_contacts"] == (result.load > 0.0).sum()
    assert found["displacement_um"] == pytest.approx(1e6 * result.centreline[0, 2], rel=1e-12)
    ball, side = found["at"].split()
    assert result.load[int(ball) - 1, SIDES.index(side)] == result.load.max()
