"""Where the program runs: outputs nobody reads, folders that cannot be written, what killed processes left."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.copies import ROOT
from tests.processes import COMMAND, python, ran

from rollbench.compare import cli, errors, files
from rollbench.compare.report import several
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.meshes.files import temporary_path

FULL = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs the device /dev/full")
SAID = "rollbench: standard output: No space left on device\n"


FILLED = [pytest.param(words, "/dev/full", (74, SAID), marks=FULL) for words in ("list", "list --json", "schema")]


@pytest.mark.parametrize(("words", "to", "ended"), [*FILLED, ("list", "&-", (0, ""))])
def test_a_full_output_ends_in_one_line_and_a_closed_one_in_none(words, to, ended):
    done = ran("/bin/sh", "-c", f'"$@" >{to}', "sh", *COMMAND, *words.split())
    assert (done.returncode, done.stderr) == ended


@pytest.mark.parametrize("words", [("list",), ("solve", "--help"), ("list", "--json")])
def test_a_reader_who_goes_away_is_told_by_the_code(words):
    code = "import sys; from rollbench.compare.cli import main; sys.argv[0] = 'rollbench'; main(sys.argv[1:])"
    with subprocess.Popen([sys.executable, "-c", code, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        said = process.stderr.read()
        assert (process.wait(), said) == (141, b"")


def test_nothing_of_a_machine_stands_in_what_is_written(command, tmp_path, monkeypatch):
    """Neither a path nor the machine's name, in no file and in no name of one: files are committed and passed on."""
    monkeypatch.setattr("platform.node", lambda: "my-machine")
    (tmp_path / "my.toml").write_text(catalogue.shipped_scene_text("two-balls"), encoding="utf-8")
    lin, over = f"{tmp_path}/my.toml --model lin", "errors.balls.oversize"
    for line in (
        f"new {tmp_path}/new.toml --kind axis",
        f"solve {lin} --loads-csv {tmp_path}/loads.csv",
        f"table {lin} --quantities load --over {over}=1:9000:2um --out {tmp_path}/t.json",  # the second is refused
        f"sweep {lin} --vary {over}=1:7um --samples 2 --out {tmp_path}/sweep",
        f"export {tmp_path}/my.toml --format json --out {tmp_path}/s.json",
        f"check {tmp_path}/my.toml --loads {tmp_path}/loads.csv --no-compute --markdown {tmp_path}/g.md",
    ):
        command(*line.split())
    found = {path: str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    texts = {name: name + path.read_text(encoding="utf-8") for path, name in found.items() if path.is_file()}
    assert {"new.toml", "t.json", "sweep/summary.json", "s.json", "g.md"} <= texts.keys()
    words = str(tmp_path), "my-machine", str(Path.home()), str(ROOT), "file:"
    assert [(name, word) for name, text in texts.items() for word in words if word in text] == []


def test_of_several_files_none_is_written_where_one_cannot_be(tmp_path):
    """The disc has room for the table (1 KB), not for its figure."""
    words = "table two-balls --model lin --quantities load --over errors.balls.oversize=4:7:2um --out t.csv"
    for limit, code, names in (("unlimited", 0, {"t.csv", "t.svg"}), ("8", 2, set())):
        (tmp_path / limit).mkdir()
        done = ran("/bin/sh", "-c", f'ulimit -f {limit}; "$@"', "sh", *COMMAND, *words.split(), cwd=tmp_path / limit)
        assert (done.returncode, {path.name for path in (tmp_path / limit).iterdir()}) == (code, names), done.stderr


@pytest.mark.parametrize("end", ["2>&-", pytest.param("2>/dev/full", marks=FULL)])
@pytest.mark.parametrize("words", [("solve", "no-such-scene"), ("solve", "--no-such-option")])
def test_bad_input_ends_with_2_whoever_reads_of_it(end, words):
    done = ran("/bin/sh", "-c", f'"$@" {end}', "sh", *COMMAND, *words)
    assert (done.returncode, done.stdout) == (2, "")


def test_what_a_killed_process_left_is_removed(tmp_path):
    # no process has this number; that of an ended one may be given to another process
    path, dead = tmp_path / "a.json", f"-{2**31 - 1}-"
    mine, alive = temporary_path(path, "json"), f"-{os.getpid()}-"
    left, folder = (Path(str(name).replace(alive, dead)) for name in (mine, temporary_path(path, "new")))
    folder.mkdir()
    for other in (mine, left, tmp_path / ".a.json.notes.tmp", folder / "x"):
        other.write_text("half")
    files.replace_file(path, "whole")
    temporary_path(path, "new")
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([mine.name, ".a.json.notes.tmp", "a.json"])


def test_no_code_comes_from_the_working_folder(tmp_path):
    """A numpy.py beside a scene was executed by children of pictures and bench."""
    (tmp_path / "numpy.py").write_text("raise SystemExit('code of the working folder ran')")
    code = """
from rollbench.compare.studies.run_times import run_timed_python_process
from rollbench.reports import offscreen
try:
    offscreen.draw_in_child_process("rollbench.reports.nowhere", None, "x.png")
except RuntimeError as error:
    print(error)
print(run_timed_python_process(["-c", "import numpy; print(numpy.__file__)"], {}, ".").printed_output)
"""
    done = python("-P", "-c", code, cwd=tmp_path, environ={"PYTHONPATH": str(ROOT / "src")})
    assert "working folder ran" not in done.stdout + done.stderr
    assert "rollbench.reports.nowhere" in done.stdout
    assert "numpy/__init__.py" in done.stdout
    assert str(tmp_path) not in done.stdout


def test_control_characters_of_a_scene_are_escaped():
    text = catalogue.shipped_scene_text("lin-case1").replace('title = "', 'title = "\\u001b[31m\\u202e', 1)
    scene = scene_file.scene_from_text(text, "bad\x1bname.toml")
    assert scene.title.startswith("\\x1b[31m\\u202e")
    assert scene.name == "bad\\x1bname"


def test_an_output_that_cannot_be_made_is_refused_before_any_work(tmp_path, monkeypatch, command):
    (tmp_path / "file").write_text("")
    for bad in (tmp_path, tmp_path / "file" / "x.npz"):
        with pytest.raises(errors.InputError):
            files.check_writable(bad)
    files.check_writable(tmp_path / "new" / "x.npz")
    assert list((tmp_path / "new").iterdir()) == []
    monkeypatch.setattr(several, "solve_and_make_page", lambda *_: pytest.fail("work was done"))
    for words in (["two-balls"], ["--only", "overview"]):
        assert "Not a directory" in command.refused("report", *words, "--out", tmp_path / "file" / "page")


def test_a_matplotlibrc_of_the_working_folder_changes_no_figure(tmp_path):
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nlines.linewidth: 9\nfigure.facecolor: red\n")
    program = """
from pathlib import Path
from types import SimpleNamespace
from rollbench.reports.figures import draw_figure
from rollbench.reports.content import Figure, Panel, Series
print(draw_figure(Figure("f", "t", [Panel("p", "x", "y", [Series("a", [0.0, 1.0], [0.0, 1.0], "line")])])))
"""
    drawn = [python("-P", "-c", program, cwd=place) for place in (tmp_path, tmp_path.parent)]
    assert [one.returncode for one in drawn] == [0, 0], drawn[0].stderr
    assert drawn[0].stdout == drawn[1].stdout


def test_escape_characters_of_names_are_not_printed_raw(tmp_path, monkeypatch, command):
    name = "a\x1b[31mred\x07.toml"
    (tmp_path / name).write_text(catalogue.shipped_scene_text("two-balls"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for said in (command("solve", "--loads-csv", "b\x1b.csv", name), command("new", "c\x1b.toml", "--like", "40x10")):
        assert "\x1b" not in said.out + said.err
        assert "\\x1b" in said.out + said.err


@pytest.mark.parametrize("words", [["list"], ["solve", "no-such-scene"]])
def test_a_caller_keeps_its_own_handler_of_term(words):
    def handler(*_):
        pytest.fail("TERM came")

    before = signal.signal(signal.SIGTERM, handler)
    try:
        with pytest.raises(SystemExit):
            cli.main(words)
        assert signal.getsignal(signal.SIGTERM) is handler
    finally:
        signal.signal(signal.SIGTERM, before)
