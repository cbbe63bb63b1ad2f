"""The command line as a user meets it: exit codes, one line for bad input, exactly one JSON object."""

import re
import shlex
import tomllib
from pathlib import Path
from unittest.mock import Mock

import pytest

from rollbench.compare.cli import COMMANDS, app_with_commands
from rollbench.compare.commands import printed as listing
from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.compare.scenes.kinds import friction_scene_kinds

#: Command lines that are refused: exit status 2, nothing on standard output and one line that says why.
REFUSED = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))["refused"]


def test_a_scene_without_equilibrium_is_said_and_exits_1(command, scene_file) -> None:
    free = scene_file(shipped_scene_text("lin-case1"), ('fix = ["ux", "uy", "rx", "ry", "rz"]', 'fix = ["ux"]'))
    code, data = command.json("solve", free, "--json")
    assert code == 1
    assert data["status"].startswith("not held: screw motion along the helix")
    assert data["balls"][0]["load_N"]["SL"] is None


def test_new_never_overwrites(command, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    command.said("new", file)
    before = file.read_text()
    assert "existing file" in command.refused("new", file)
    assert file.read_text() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.toml"]
    assert command("new", tmp_path / "no" / "mine.toml").code == 2


#: But for the screw in time, whose template is read as all are (test_schema) and takes twenty seconds to solve.
KINDS = ["ball-screw", "bearing", *(kind.replace(" ", "-") for kind in friction_scene_kinds() if kind != "screw run")]


@pytest.mark.parametrize("kind", [pytest.param(x, marks=pytest.mark.slow if x == "linear-chain" else ()) for x in KINDS])
def test_new_scene_of_a_kind_solves_as_written(kind: str, command, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    advised = command.said("new", file, "--kind", kind).split("rollbench ")[1].split()[0]
    assert advised == ("friction" if kind in KINDS[2:] else "solve")
    command.answer(advised, file)


def test_a_foreign_folder_takes_no_report(command, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    assert "--out" in command.refused("report", "--out", tmp_path)
    assert (tmp_path / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_knows_commands_and_options(shell: str, command) -> None:
    out = command.said("completion", shell)
    assert [words for words in ("mesh-study", "stiffness-at", "rollbench") if words not in out] == []


def test_an_interrupt_is_said(command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listing, "_shipped_contents_lines", Mock(side_effect=KeyboardInterrupt))
    code, _, err = command("list")
    assert (code, err) == (130, "rollbench: interrupted; nothing was left half-written\n")


@pytest.mark.parametrize(
    ("line", "words"),
    [pytest.param(x, words, marks=pytest.mark.slow if x.startswith("bench") else ()) for x, *words in REFUSED],
)
def test_a_refused_command_line_says_why_in_one_line(command, line: str, words: list[str]) -> None:
    said = command.refused(*shlex.split(line))
    assert [word for word in words if word not in said] == []


def test_every_option_with_a_number_refuses_underscores(command) -> None:
    """Python reads 1_000 as a number; a typist may have meant 1.000 or 1e000."""
    app, count = app_with_commands("completion"), 0
    for name in (name for group in COMMANDS.values() for name in group):
        arguments = app[name].assemble_argument_collection()
        needed = [x for x in arguments if x.field_info.required]
        words = [y for x in needed for y in ((x.name, "a.b=1,2") if x.field_info.is_keyword_only else ("x",))]
        for option in arguments:
            if {"int", "float"} & set(re.findall("[a-z]+", str(option.hint))):
                code, out, err = command(name, *words, option.name, "1_0")
                assert (code, out) == (2, ""), name
                assert option.name in err
                assert "leave the underscore out" in err
                count += 1
    assert count > 30
