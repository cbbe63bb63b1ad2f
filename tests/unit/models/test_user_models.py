"""Models of other packages, and programs of any language: judged as ours are, what they read and may write, what is said
where they fail."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.errors import InputError, ProgramError
from rollbench.compare.models import programs, user_models
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.meshes.errors import draw_geometry_with_errors, scene_with_drawn_errors
from rollbench.meshes.helix import ball_layout, lead_per_radian
from rollbench.meshes.parts import FourierTerm, SideErrors

pytestmark = pytest.mark.slow

EXAMPLE = ROOT / "docs/examples/mei_model"
PROGRAMS = ROOT / "docs/examples/programs"
SHARE = rollbench.model_command(f"awk -f {PROGRAMS / 'share.awk'} {{scene.json}} {{loads.csv}}")
needs_awk = pytest.mark.skipif(shutil.which("awk") is None, reason="no awk here")


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Installs a model with the text of its module, under a name."""

    def install(text, point="mine_module:model", name="mine"):
        module = point.partition(":")[0]
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n", encoding="utf-8")
        (info / "entry_points.txt").write_text(f"[rollbench.models]\n{name} = {point}\n", encoding="utf-8")
        monkeypatch.delitem(sys.modules, module, raising=False)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.chdir(tmp_path)
        forget()

    yield install
    monkeypatch.undo()
    forget()


def forget():
    user_models.entry_points_of_installed_models.cache_clear()
    user_models.load_user_model.cache_clear()


@pytest.fixture
def example(installed):
    """The example of the manual, as its pyproject.toml names it."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    ((name, point),) = project["entry-points"]["rollbench.models"].items()
    installed((EXAMPLE / "mei_model.py").read_text(encoding="utf-8"), point, name)
    yield name
    sys.modules.pop("mei_model", None)


def test_the_example_finds_the_loads_of_mei(example):
    mine, ours = rollbench.solve("lin-case1", example), rollbench.solve("lin-case1", "mei")
    np.testing.assert_allclose(mine.loads, ours.loads, rtol=0.0, atol=1e-9)
    assert mine.nut.displacement == pytest.approx(ours.nut.displacement, rel=1e-9)
    assert mine.load_point.displacement is None, "the model states the motion at the nut only"
    assert pytest.approx(ours.life.L10, rel=1e-9) == mine.life.L10
    assert (mine.worst.element, mine.worst.pressure) == (ours.worst.element, pytest.approx(ours.worst.pressure, rel=1e-9))
    assert mine.to_dict()["equilibrium"]["force_residual"] < 1e-10
    assert mine.to_dict()["warnings"] == []


def test_the_function_of_the_manual_s_page_is_a_model(installed):
    page = (ROOT / "docs/tutorials/your-model.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"%%writefile equal_shares.py\n((?:.|\n)*?)```", page)
    installed(text, *re.findall(r'\nequal-shares = "(equal_shares:contact_loads)"', page))
    loads = rollbench.solve("lin-case1", "mine").loads
    np.testing.assert_allclose(loads[:, [0, 3]], rollbench.solve("lin-case1", "mei").loads[:, 0].mean(), rtol=1e-9)


def test_it_is_compared_and_judged_as_ours_are(example, command):
    found = rollbench.compare_models("lin-case1", [example, "mei"])
    mine, ours = found.models[example], found.models["mei"]
    assert mine.errors == pytest.approx(ours.errors, abs=1e-9)
    assert (mine.ball, mine.side, mine.seconds > 0.0) == (ours.ball, ours.side, True)
    assert found.expected_error.loads is None
    assert "your model has not been compared with the 3D reference" in found.expected_error.words
    verdicts = [command("check", "lin-case1", "--no-compute", "--model", name) for name in (example, "mei")]
    assert verdicts[0].code == verdicts[1].code == 1
    assert verdicts[0].out == verdicts[1].out.replace("mei", example)


def test_specimens_and_samples_are_solved_by_it(example, command, tmp_path):
    scene, tables = catalogue.scene("lin-random"), []
    for member in (0, 3):
        options = ModelOptions(member=member)
        mine, ours = (run_model(scene, name, options).load for name in (example, "mei"))
        np.testing.assert_allclose(mine, ours, rtol=0.0, atol=1e-8)
    assert command.answer("solve", "lin-random", "--members", "3", "--model", example)["model"] == example
    for name in (example, "mei"):
        vary, out = ["loads[0].force[2]=1 kN:5 kN"], tmp_path / name
        rollbench.sweep("lin-case1", vary, samples=3, method="grid", model=name, out=out)
        tables.append(np.genfromtxt(out / "samples.csv", delimiter=",", names=True)["largest_load_N"])
    np.testing.assert_allclose(*tables, rtol=1e-10)


def test_a_specimen_is_written_into_its_scene():
    scene, waves = catalogue.scene("lin-random"), (FourierTerm(1.0, 3e-6, 0.0, 1e-6),)
    groove = SideErrors(profile=(1e-6, 2e-6), profile_sigma=(1e-7,) * 3, pitch=waves, pitch_along="axis")
    scene = replace(scene, errors=replace(scene.errors, SR=groove, NL=replace(groove, roundness=waves)))
    specimen, layout = scene_with_drawn_errors(scene, 2), ball_layout(scene)
    drawn, written = draw_geometry_with_errors(scene, layout, 2), draw_geometry_with_errors(specimen, layout)
    for what in ("ball_radii", "groove_centres", "groove_centre_derivatives", "groove_radii", "profile_coefficients"):
        np.testing.assert_allclose(getattr(written, what), getattr(drawn, what), rtol=1e-14, atol=0.0)
    assert not specimen.errors.random


def test_pressure_that_it_gives_is_shown_and_judged(installed, command):
    installed(
        "import numpy as np, rollbench\n"
        "def model(scene):\n"
        "    loads = rollbench.solve(scene, 'mei').loads\n"
        "    return rollbench.ModelAnswer(loads, pressure=np.where(loads > 0.0, 3e9, 0.0))\n"
    )
    assert rollbench.solve("lin-case1", "mine").pressure.max() == 3e9
    compared = rollbench.compare_models("lin-case1", ["mine"]).models["mine"]
    assert (compared.pressure, np.isnan(compared.displacement)) == (3e9, True)
    summary = command.answer("solve", "lin-case1", "--model", "mine")["summary"]
    assert summary["worst_contact"]["pressure_MPa"] == 3000.0
    assert summary["nut"]["displacement_um"] is summary["rigidities_N_per_um"]["with_unequal_loads"] is None
    words = ("check", "lin-case1", "--no-compute", "--max-error", "90", "--limit", "pressure=10", "--model", "mine")
    assert "against 2" in command(*words).out


LOADS = "import numpy as np\ndef model(scene):\n    loads = np.zeros((scene.ball_count, 4))\n"
#: Faulty models: module, and what the error names.
FAULTY = {
    "shape": (LOADS + "    return loads[:, :2]", "loads of shape (32, 2) from mine; allowed: an array of shape (32, 4)"),
    "nan": (LOADS + "    loads[3, 1] = np.nan\n    return loads", "loads of nan on ball 4, SR"),
    "negative": (LOADS + "    loads[0, 2] = -5.0\n    return loads", "loads of -5 on ball 1, NL"),
    "words": (LOADS + "    return 'ten'", "loads from mine that are not numbers"),
    "displacement": (
        LOADS + "    from rollbench import ModelAnswer\n    return ModelAnswer(loads, displacement=np.zeros(3))",
        "displacement of shape (3,)",
    ),
    "exception": ("def model(scene):\n    raise RuntimeError('no\\nlicence')", "mine fails with RuntimeError: no licence"),
    "import": ("import absent_solver", "No module named 'absent_solver'"),
    "attribute": ("", "AttributeError"),
    "number": ("model = 3", "an object of type int instead of a function"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_a_faulty_model_is_one_error(installed, command, fault):
    text, expected = FAULTY[fault]
    installed(text)
    for words in (("solve", "lin-case1"), ("check", "lin-case1", "--no-compute")):
        assert expected in command.refused(*words, "--model", "mine")


def test_it_is_named_by_list_and_not_loaded_and_a_name_of_ours_stays_ours(installed, command):
    installed("raise RuntimeError('loaded')")
    installed("raise RuntimeError('loaded')", "other_module:model", "mei")
    assert command.answer("list")["models of other packages"] == {"mine": "mine_module:model, mine_module 1.0"}
    assert "mine_module:model" in command.said("list")
    assert "mine; advice: did you mean" in command.refused("solve", "lin-case1", "--model", "mein")
    command.said("solve", "lin-case1", "--model", "mei")


def test_a_name_of_two_packages_is_refused(installed):
    installed(LOADS + "    return loads", "first_module:model")
    installed(LOADS + "    return loads", "second_module:model")
    with pytest.raises(InputError, match="also has this name"):
        rollbench.solve("lin-case1", "mine")


def test_several_sets_on_one_shaft_are_refused_in_one_line(installed, command):
    installed(LOADS + "    return loads")
    for words in (("solve", "double-nut"), ("check", "double-nut", "--no-compute")):
        assert "mine does not solve several" in command.refused(*words, "--model", "mine")
    assert "mine" in command.refused("sweep", "double-nut", "--vary", "errors.seed=1:2", "--model", "mine")


def test_loads_that_do_not_balance_are_warned_of(installed, command):
    installed("import rollbench\ndef model(scene):\n    return rollbench.solve(scene, 'mei').loads / 1000.0\n")
    assert "loads of mine out of balance by" in command.said("solve", "lin-case1", "--model", "mine")


@pytest.fixture
def program(tmp_path, monkeypatch):
    """The command of a Python program with this text, in which `scene` and `loads` name its files; temporary files of its
    runs go to a folder that must be empty in the end."""
    runs = tmp_path / "runs"
    runs.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(runs))
    monkeypatch.chdir(tmp_path)

    def write(text):
        head = "import json, sys, time\nscene, loads = sys.argv[1:]\n"
        (tmp_path / "mine.py").write_text(f"{head}{text}\n", encoding="utf-8")
        return rollbench.model_command(f"{sys.executable} mine.py {{scene.json}} {{loads.csv}}")

    yield write
    assert [*runs.iterdir()] == []


@needs_awk
def test_a_program_shares_an_axial_load_as_rigid_parts_do():
    """All balls alike: the share by equilibrium; with preload what closes one pair of flanks opens the other."""
    track = catalogue.scene("lin-case1").track
    slope = np.sin(track.contact_angle) * np.cos(np.arctan2(track.lead / (2.0 * np.pi), track.pitch_radius))
    found = rollbench.solve("lin-case1", SHARE)
    np.testing.assert_allclose(found.loads[:, [0, 3]], 5000.0 / (32 * slope), rtol=1e-12)
    assert found.loads[:, [1, 2]].max() == 0.0
    assert found.to_dict()["equilibrium"]["force_residual"] < 1e-12
    scene = catalogue.scene("lin-case3")
    closed, opened = rollbench.solve(scene, SHARE).loads[:, :2].T
    contact = json.loads(programs.scene_json(scene))["contacts"][0]
    pressed = 2.0 * scene.errors.balls.oversize / (contact["C_SL"] + contact["C_NR"])
    np.testing.assert_allclose(closed ** (2 / 3) + opened ** (2 / 3), 2.0 * pressed, rtol=1e-6)
    np.testing.assert_allclose((closed - opened).sum() * slope, 5000.0, rtol=1e-9)


def test_the_scene_of_a_program_has_hertz_constants_and_places_of_its_balls():
    read, solved = json.loads(programs.scene_json(catalogue.scene("lin-case1"))), rollbench.solve("lin-case1", "mei")
    worst, contacts = solved.worst, read["contacts"]
    constant = contacts[worst.element - 1][f"C_{worst.side}"]
    assert constant * solved.loads.max() ** (2 / 3) == pytest.approx(worst.approach, rel=1e-9)
    assert [x["ball"] for x in contacts] == [*range(1, 33)]
    rise = np.diff([x["z"] for x in contacts]) / np.diff([x["azimuth"] for x in contacts])
    np.testing.assert_allclose(rise, read["track"]["lead"] / (2.0 * np.pi), rtol=1e-9)
    assert read["given"]["axial_force"] == read["loads"][0]["force"][2] == 5000.0


#: A program that answers, every ball alike, and how it ends.
ANSWER = """
rows = ["ball,flank,newton"] + [f"{k + 1},{flank},{100.0 + k}" for k in range(32) for flank in ("SL", "SR", "NL", "NR")]
open(loads, "w").write("\\n".join(rows) + "\\n")
"""
#: Programs that do not answer, and what is said. (Contents of files of loads: `tests/unit/gate/test_spreadsheets.py`.)
SILENT = {
    "exit code": ("print('reading'); print('no licence\\n\\n'); sys.exit(3)", "exit code 3; its last line: no licence"),
    "exception": ("raise ValueError('no root')", "exit code 1; its last line: ValueError: no root"),
    "signal": ("import os, signal; os.kill(os.getpid(), signal.SIGTERM)", "ended by signal 15; it printed nothing"),
    "nothing": ("print('done')", "wrote no {loads.csv}; its last line: done"),
    "nonsense": ("open(loads, 'wb').write(bytes(range(256)))", "cannot be used, file: a binary file"),
    "displacement": (ANSWER.replace('["ball', '["# displacement: 1 2 x"] + ["ball'), "1 2 x; allowed: six numbers"),
    "late": ("print('at work', flush=True); time.sleep(60)", "time limit of 0.5 s; its last line: at work"),
}


@pytest.mark.parametrize("fault", SILENT)
def test_a_program_without_answer_is_one_error_with_its_last_line(program, command, tmp_path, fault):
    text, expected = SILENT[fault]
    words = program(text), *(("--model-seconds", 0.5) if fault == "late" else ())
    before = {*tmp_path.iterdir()}
    code, out, err = command("check", "lin-case1", "--no-compute", "--junit", "junit.xml", "--model-command", *words)
    assert (code, out, err.count("\n")) == (1, "", 1), err
    assert expected in err
    assert {*tmp_path.iterdir()} == before


def test_the_answer_of_a_program_is_taken(program):
    moved = 'at = json.load(open(scene))["given"]["axial_force"] / 5000.0'
    answer = ANSWER.replace('["ball', '[f"# displacement: 0 0 {3e-6 * at} 0 0 {1e-5 * at}"] + ["ball')
    found = rollbench.solve("lin-case1", program(moved + answer))
    np.testing.assert_array_equal(found.loads, np.repeat(100.0 + np.arange(32.0), 4).reshape(32, 4))
    np.testing.assert_array_equal(found.solution.centreline, [[0.0, 0.0, 3e-6, 0.0, 0.0, 1e-5]])
    assert found.nut.displacement == pytest.approx(3e-6 - 1e-5 * lead_per_radian(catalogue.scene("lin-case1").track))
    assert found.displacement is None, "the model states the motion at the nut, and the load acts elsewhere"


SWEEP = "sweep lin-case1 --vary loads[0].force[2]=1kN:5kN --samples 3 --method grid --out s"


@pytest.mark.parametrize("words", ["solve lin-case1", "compare lin-case1", SWEEP, "survey --count 2"])
def test_every_command_says_so(program, command, words):
    code, out, err = command(*words.split(), "--model-command", program("print('no licence'); sys.exit(3)"))
    assert (code, out) == (1, "")
    assert "no licence" in err.splitlines()[-1]
    assert "Traceback" not in err


def test_what_a_late_program_started_ends_with_it(program, tmp_path):
    child = (
        "from subprocess import Popen\nPopen([sys.executable, '-c', 'import time; time.sleep(3); open(\"late\", \"w\")'])"
    )
    command = rollbench.model_command(program(f"{child}\ntime.sleep(60)"), seconds=1.0)
    start = time.monotonic()
    with pytest.raises(ProgramError, match="time limit of 1 s"):
        rollbench.solve("lin-case1", command)
    time.sleep(max(0.0, start + 5.0 - time.monotonic()))
    assert not (tmp_path / "late").exists()


def runs(pid: int) -> bool:
    """Whether a process runs: it is there, and is no zombie that nobody has waited for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked up in /proc")
def test_a_killed_parent_leaves_no_program_running(program, tmp_path):
    child = "from subprocess import Popen\np = Popen([sys.executable, '-c', 'import time; time.sleep(300)'])"
    mine = program(f"{child}\nimport os\nopen('pids', 'w').write(f'{{os.getpid()}} {{p.pid}} .')\ntime.sleep(300)")
    code = f"import rollbench; rollbench.solve('lin-case1', rollbench.model_command({str(mine)!r}, seconds=300))"
    there = os.environ | {"PYTHONPATH": str(ROOT / "src"), "TMPDIR": str(tmp_path)}
    parent = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, env=there)
    pids, last = tmp_path / "pids", time.monotonic() + 120.0
    while not (pids.exists() and pids.read_text(encoding="utf-8").endswith(".")):
        assert time.monotonic() < last
        time.sleep(0.05)
    ran = [int(word) for word in pids.read_text(encoding="utf-8").split()[:2]]
    assert all(map(runs, ran))
    parent.kill()
    parent.wait()
    while any(map(runs, ran)) and time.monotonic() < last:
        time.sleep(0.05)
    left = [pid for pid in ran if runs(pid)]
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert left == []


def test_a_name_runs_no_program(program, command, tmp_path):
    """Only `model_command` and the option do, also where the same words have run before as a command."""
    mine = program(f"open('ran', 'w').close()\n{ANSWER}")
    for model in (str(mine), f"{mine} {{seconds=5}}"):
        assert "--model-command" in command.refused("solve", "lin-case1", "--model", model)
        with pytest.raises(InputError, match="a name runs no program"):
            rollbench.check("lin-case1", model=model, compute=False)
    assert not (tmp_path / "ran").exists()
    assert rollbench.solve("lin-case1", mine).loads[0, 0] == 100.0
    (tmp_path / "ran").unlink()
    with pytest.raises(InputError, match="a name runs no program"):
        rollbench.solve("lin-case1", str(mine))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("command_of", "expected"),
    [
        ("mine {scene.json}", "{loads.csv} once"),
        ("mine {loads.csv} {loads.csv} {scene.json}", "{loads.csv} once"),
        ("mine '{scene.json} {loads.csv}", "No closing quotation"),
        ("{scene.json} {loads.csv}", "a command that begins with a program"),
        ("mine {scene.json} {loads.csv} {seconds=0}", "above 0 and up to 1e\\+06"),
        ("mine {scene.json} {loads.csv} {seconds=x}", "above 0 and up to 1e\\+06"),
    ],
)
def test_a_command_that_is_none_is_bad_input(command_of, expected):
    with pytest.raises(InputError, match=expected) as refused:
        rollbench.model_command(command_of)
    assert refused.value.code == 2


def test_a_program_that_is_not_there_is_told(command):
    check, absent = ("check", "lin-case1", "--no-compute"), "./absent {scene.json} {loads.csv}"
    code, out, err = command(*check, "--model-command", absent)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert "absent: lin-case1: cannot be started: No such file" in err
    assert "--model-command" in command.refused(*check, "--model", "lin", "--model-command", absent)
    assert "with --model-command" in command.refused(*check, "--model-seconds", "5")


@needs_awk
def test_a_program_is_compared_judged_and_swept_as_ours_are(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = rollbench.compare_models("lin-case1", [SHARE, "mei"]).models
    reference = rollbench.check("lin-case1", model=SHARE, compute=False)
    assert np.abs(found[SHARE].errors).max() == pytest.approx(reference.rows[0].of_mean.max_percent)
    assert found[SHARE].seconds > 0.0
    assert np.abs(found["mei"].errors).max() < np.abs(found[SHARE].errors).max()
    command.said(*SWEEP.split(), "--workers", "2", "--model-command", SHARE)
    table = np.genfromtxt(tmp_path / "s/samples.csv", delimiter=",", names=True)
    uniform = rollbench.solve("lin-case1", "mei").loads[:, 0].mean()
    np.testing.assert_allclose(table["largest_load_N"], uniform * np.array([0.2, 0.6, 1.0]), rtol=1e-9)
    changed = (PROGRAMS / "share.awk").read_text(encoding="utf-8") + "# changed\n"
    (tmp_path / "share.awk").write_text(changed, encoding="utf-8")
    other = "awk -f share.awk {scene.json} {loads.csv}"
    assert "another computation" in command.refused(*SWEEP.split(), "--model-command", other)
    assert command.answer("solve", "lin-random", "--members", "3", "--model-command", SHARE)["converged"] == 3
