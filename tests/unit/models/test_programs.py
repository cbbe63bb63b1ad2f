"""Models that are programs of any language: what they read, what they may write, and what is said where they fail."""

import json
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.errors import InputError, ProgramError
from rollbench.compare.models import programs
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.meshes.errors import scene_with_drawn_errors

EXAMPLES = ROOT / "docs/examples/programs"
SHARE = f"awk -f {EXAMPLES / 'share.awk'} {{scene.json}} {{loads.csv}}"
needs_awk = pytest.mark.skipif(shutil.which("awk") is None, reason="no awk here")


@pytest.fixture
def program(tmp_path, monkeypatch):
    """The command of a Python program with this text, in which `scene` and `loads` name its files; temporary files of its
    runs go to a folder that must be empty in the end."""
    runs = tmp_path / "runs"
    runs.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(runs))
    monkeypatch.chdir(tmp_path)

    def write(text):
        (tmp_path / "mine.py").write_text(
            f"import json, sys, time\nscene, loads = sys.argv[1:]\n{text}\n", encoding="utf-8"
        )
        return f"{sys.executable} mine.py {{scene.json}} {{loads.csv}}"

    yield write
    assert [*runs.iterdir()] == []


@needs_awk
def test_a_program_shares_an_axial_load_as_rigid_parts_do():
    """All balls alike: the share by equilibrium; with preload what closes one pair of flanks opens the other."""
    scene = catalogue.scene("lin-case1")
    found = rollbench.solve(scene, SHARE)
    lead = np.arctan2(scene.track.lead / (2.0 * np.pi), scene.track.pitch_radius)
    slope = np.sin(scene.track.contact_angle) * np.cos(lead)
    np.testing.assert_allclose(found.loads[:, [0, 3]], 5000.0 / (32 * slope), rtol=1e-12)
    assert found.loads[:, [1, 2]].max() == 0.0
    assert found.to_dict()["equilibrium"]["force_residual"] < 1e-12
    preloaded = rollbench.solve("lin-case3", SHARE)
    closed, opened = preloaded.loads[:, 0], preloaded.loads[:, 1]
    scene = catalogue.scene("lin-case3")
    contact = json.loads(programs.scene_json(scene))["contacts"][0]
    pressed = 2.0 * scene.errors.balls.oversize / (contact["C_SL"] + contact["C_NR"])
    np.testing.assert_allclose(closed ** (2 / 3) + opened ** (2 / 3), 2.0 * pressed, rtol=1e-6)
    np.testing.assert_allclose((closed - opened).sum() * slope, 5000.0, rtol=1e-9)


@needs_awk
def test_every_ball_of_a_specimen_stands_at_one_displacement():
    """Loads of balls of drawn radii: one motion of the screw closes every loaded pair as far as Hertz says."""
    scene = scene_with_drawn_errors(catalogue.scene("lin-random"), 3)
    loads = run_model(scene, SHARE, ModelOptions(estimate_beam_mesh_error=False)).load
    read = json.loads(programs.scene_json(scene))
    angle, lead = read["track"]["contact_angle"], read["given"]["lead_angle"]
    larger = dict(read["errors"]["balls"]["listed"])
    pair = np.array([x["C_SL"] + x["C_NR"] for x in read["contacts"]])
    own = np.array([2.0 * larger[x["ball"]] for x in read["contacts"]])  # a ball larger by e closes its pair by 2 e
    moved = (pair * loads[:, 0] ** (2 / 3) - own) / (np.sin(angle) * np.cos(lead))
    assert loads[:, 0].min() > 0.0
    assert np.ptp(loads[:, 0]) > 0.1 * loads.max()
    np.testing.assert_allclose(moved, moved.mean(), rtol=1e-9)


def test_the_scene_of_a_program_has_hertz_constants_and_places_of_its_balls():
    read, solved = json.loads(programs.scene_json(catalogue.scene("lin-case1"))), rollbench.solve("lin-case1", "mei")
    worst, contacts = solved.worst, read["contacts"]
    constant = contacts[worst.element - 1][f"C_{worst.side}"]
    assert constant * solved.loads.max() ** (2 / 3) == pytest.approx(worst.approach, rel=1e-9)
    assert [x["ball"] for x in contacts] == [*range(1, 33)]
    rise = np.diff([x["z"] for x in contacts]) / np.diff([x["azimuth"] for x in contacts])
    np.testing.assert_allclose(rise, read["track"]["lead"] / (2.0 * np.pi), rtol=1e-9)
    assert read["given"]["axial_force"] == read["loads"][0]["force"][2] == 5000.0


@pytest.mark.skipif(shutil.which("cc") is None, reason="no compiler here")
def test_a_program_in_c_is_a_model(tmp_path):
    made = tmp_path / "equal"
    subprocess.run(["cc", "-o", made, EXAMPLES / "equal.c", "-lm"], check=True)
    found = rollbench.solve("lin-case1", f"{made} {{scene.json}} {{loads.csv}}").loads
    np.testing.assert_allclose(found[:, [0, 3]], rollbench.solve("lin-case1", "mei").loads[:, 0].mean(), rtol=1e-9)


#: A program that answers, every ball alike, and how it ends.
ANSWER = """
rows = ["ball,flank,newton"] + [f"{k + 1},{flank},{100.0 + k}" for k in range(32) for flank in ("SL", "SR", "NL", "NR")]
open(loads, "w").write("\\n".join(rows) + "\\n")
"""
#: Programs that do not answer, and what is said.
FAULTY = {
    "exit code": ("print('reading'); print('no licence\\n\\n'); sys.exit(3)", "exit code 3; its last line: no licence"),
    "exception": ("raise ValueError('no root')", "exit code 1; its last line: ValueError: no root"),
    "signal": ("import os, signal; os.kill(os.getpid(), signal.SIGTERM)", "ended by signal 15; it printed nothing"),
    "nothing": ("print('done')", "wrote no {loads.csv}; its last line: done"),
    "nonsense": ("open(loads, 'wb').write(bytes(range(256)))", "cannot be used, file: a binary file"),
    "empty": ("open(loads, 'w')", "line 1: nothing; allowed: ball, flank"),
    "columns": ("open(loads, 'w').write('ball,load\\n1,2\\n')", "a column flank"),
    "nan": (ANSWER.replace("{100.0 + k}", "{'nan' if k == 3 else 1}"), "newton: nan; allowed: a number, at least 0"),
    "negative": (ANSWER.replace("{100.0 + k}", "{-1.0}"), "newton: -1.0; allowed: a number, at least 0"),
    "too few balls": (ANSWER.replace("range(32)", "range(31)"), "no load of ball 32 SL and 3 more"),
    "too many balls": (ANSWER.replace("range(32)", "range(33)"), "ball: 33; allowed: a ball number from 1 to 32"),
    "too few flanks": (ANSWER.replace('"SL", "SR", ', ""), "no rows for SL, SR"),
    "a contact twice": (ANSWER.replace('("SL", "SR"', '("SL", "SL", "SR"'), "a second row of ball 1 SL"),
    "displacement": (
        ANSWER.replace('["ball', '["# displacement: 1 2 x"] + ["ball'),
        "# displacement: 1 2 x; allowed: six numbers ux uy uz",
    ),
    "late": (
        "print('at work', flush=True); time.sleep(60)",
        "was ended after its time limit of 0.5 s; its last line: at work",
    ),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_a_program_without_answer_is_one_error_with_its_last_line(program, command, tmp_path, fault):
    text, expected = FAULTY[fault]
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
    np.testing.assert_array_equal(found.displacement, [0.0, 0.0, 3e-6, 0.0, 0.0, 1e-5])


@pytest.mark.parametrize("way", ["solve", "compare", "sweep", "survey"])
def test_every_command_says_so(program, command, way):
    words = {
        "solve": ("solve", "lin-case1"),
        "compare": ("compare", "lin-case1"),
        "sweep": ("sweep", "lin-case1", "--vary", "loads[0].force[2]=1 kN:5 kN", "--samples", "2", "--method", "grid"),
        "survey": ("survey", "--count", "2"),
    }
    code, out, err = command(*words[way], "--model-command", program("print('no licence'); sys.exit(3)"))
    assert (code, out) == (1, "")
    assert "no licence" in err.splitlines()[-1]
    assert "Traceback" not in err


def test_what_a_late_program_started_ends_with_it(program, tmp_path):
    child = (
        "import subprocess; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(3); open(\"late\", \"w\")'])"
    )
    command = rollbench.model_command(program(f"{child}\ntime.sleep(60)"), seconds=1.0)
    start = time.monotonic()
    with pytest.raises(ProgramError, match="time limit of 1 s"):
        rollbench.solve("lin-case1", command)
    time.sleep(max(0.0, start + 5.0 - time.monotonic()))
    assert not (tmp_path / "late").exists()


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
    check = ("check", "lin-case1", "--no-compute")
    code, out, err = command(*check, "--model-command", "./absent {scene.json} {loads.csv}")
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert "absent: lin-case1: cannot be started: No such file" in err
    code, _, err = command(
        "check", "lin-case1", "--no-compute", "--model", "lin", "--model-command", "a {scene.json} {loads.csv}"
    )
    assert (code, "--model-command" in err) == (2, True)
    code, _, err = command(*check, "--model-seconds", "5")
    assert (code, "with --model-command" in err) == (2, True)


@needs_awk
def test_a_program_is_compared_judged_and_swept_as_ours_are(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = rollbench.compare_models("lin-case1", [SHARE, "mei"]).models
    uniform = rollbench.solve("lin-case1", "mei").loads[:, 0].mean()
    reference = rollbench.check("lin-case1", model=SHARE, compute=False)
    assert np.abs(found[SHARE].errors).max() == pytest.approx(reference.judged[0].of_mean.max_percent)
    assert found[SHARE].seconds > 0.0
    assert np.abs(found["mei"].errors).max() < np.abs(found[SHARE].errors).max()
    code, out, _ = command("check", "lin-case1", "--no-compute", "--model-command", SHARE)
    assert (code, "worst contact 20.76 % of the mean load off" in out) == (1, True)
    words = (
        "sweep",
        "lin-case1",
        "--vary",
        "loads[0].force[2]=1 kN:5 kN",
        "--samples",
        "3",
        "--method",
        "grid",
        "--out",
        "s",
    )
    assert command(*words, "--workers", "2", "--model-command", SHARE).code == 0
    table = np.genfromtxt(tmp_path / "s/samples.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["largest_load_N"], uniform * np.array([0.2, 0.6, 1.0]), rtol=1e-9)
    other = tmp_path / "share.awk"
    other.write_text((EXAMPLES / "share.awk").read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    code, _, err = command(*words, "--model-command", "awk -f share.awk {scene.json} {loads.csv}")
    assert (code, "another sweep" in err) == (2, True)
    code, out, _ = command("solve", "lin-random", "--members", "3", "--model-command", SHARE, "--json")
    assert (code, json.loads(out)["converged"]) == (0, 3)
