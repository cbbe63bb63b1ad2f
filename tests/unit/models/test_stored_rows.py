"""What is solved row by row resumes from its folder: the same text, JSON and CSV as without a folder, after a kill too."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.conftest import Command
from tests.load_cases import TEXT, written
from tests.slow import all_slow_but

from rollbench.compare.models import many

#: Computing time in a text or in JSON.
TIME = re.compile(r"[0-9.e+-]+ ms for each|time [0-9.e+-]+ s a screw|\"seconds\": [0-9.e+-]+")


class Spelling(NamedTuple):
    """Words of a command that solves many rows, and of the same command for another computation."""

    words: tuple[str, ...]
    other: tuple[str, ...]
    #: Number of rows.
    rows: int
    #: Option for the folder, and that for a CSV file, if there is one.
    store: str = "--store"
    csv: str = ""
    #: Whether several workers may solve the rows.
    workers: bool = False


OVER = ("table", "two-balls", "--model", "lin", "--over", "errors.balls.oversize=4 um,5 um,900 um,-900 um")
VARY = ("sweep", "two-balls", "--vary", "errors.balls.oversize=4 um:7 um", "--method", "grid", "--model", "lin")
MEMBERS = ("solve", "random.toml", "--balls", "--model", "lin", "--members")
CURVE = ("solve", "two.toml", "--model", "lin", "--curve")
BESIDE = ("solve", "two-balls", "two.toml", "--model", "lin")
SURVEY = ("survey", "--count", "6", "--model")
SPELLINGS = {
    "sweep": Spelling((*VARY, "--samples", "4"), (*VARY, "--samples", "5"), 4, "--out", workers=True),
    "table": Spelling((*OVER, "--over", "screw.conformity=0.52,0.9"), OVER, 8, csv="--out", workers=True),
    "members": Spelling((*MEMBERS, "120"), (*MEMBERS, "130"), 9, csv="--csv", workers=True),
    "curve": Spelling((*CURVE, "-300N:300N:15"), (*CURVE, "-300N:300N:16"), 3, csv="--csv"),
    "solve A B": Spelling((*BESIDE, "clearance"), BESIDE, 3),
    "load cases": Spelling(("solve", "two.toml", "--model", "lin"), ("solve", "two.toml"), 3, csv="--loads-csv"),
    "survey": Spelling((*SURVEY, "lin"), (*SURVEY, "lin-cell"), 6, workers=True),
}
each_spelling = pytest.mark.parametrize("name", all_slow_but(["members", "solve A B", "load cases"], SPELLINGS))


class GoneError(Exception):
    """Raised in place of a row that is solved."""


def gone(*_: object) -> None:
    raise GoneError


@pytest.fixture
def answers(command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[str, str, str]]:
    """Text, JSON and CSV of a spelling, with the rows of the folder "rows" unless `stored` is false."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path)
    (tmp_path / "random.toml").write_text(TEXT.replace('oversize = "5 um"', 'oversize = "5 um"\nsigma = "0.2 um"'))

    def run(spelling: Spelling, *more: str, stored: bool = True) -> tuple[str, str, str]:
        words = [*spelling.words, *more]
        if stored or spelling.store == "--out":
            words += [spelling.store, "rows" if stored else "alone"]
        if spelling.csv:
            words += [spelling.csv, "out.csv"]
        said = [command.said(*words, *form).replace("alone", "rows") for form in ((), ("--json",))]
        text, data = (TIME.sub("", one) for one in said)
        file = tmp_path / ("out.csv" if spelling.csv else f"{'rows' if stored else 'alone'}/samples.csv")
        return text, data, file.read_text() if file.exists() else ""

    return run


@each_spelling
def test_rows_are_solved_once_and_after_a_kill_those_that_it_cut_off(name, answers, command, tmp_path, monkeypatch) -> None:
    """With a folder, read from it and after a kill the answer is that without; the folder is of no other computation."""
    spelling, solve_row, solved = SPELLINGS[name], many._solve_row, []
    alone = answers(spelling, stored=False)
    assert answers(spelling) == alone
    with monkeypatch.context() as patch:
        patch.setattr(many, "_solve_row", gone)
        assert answers(spelling) == alone
    words = "got the folder of another computation, with other values of "
    assert f"{spelling.store}: {words}" in command.refused(*spelling.other, spelling.store, "rows")
    files = [*(tmp_path / "rows" / many.RECORDS).glob("*.lines")]
    lines = [line for file in files for line in file.read_bytes().splitlines(keepends=True)]
    assert len(lines) == spelling.rows
    half = spelling.rows // 2
    for file in files:
        file.unlink()
    files[0].write_bytes(b"".join(lines[:half]) + lines[half][:-9])

    def counted(solve, row, number, store):
        solved.extend([number] * (store is not None))  # a scene with load cases solves rows that are not stored
        return solve_row(solve, row, number, store)

    monkeypatch.setattr(many, "_solve_row", counted)
    assert answers(spelling) == alone
    assert len(solved) == len({*solved}) == spelling.rows - half


@pytest.mark.slow
@pytest.mark.parametrize("name", [x for x, spelling in SPELLINGS.items() if spelling.workers])
def test_two_workers_store_and_answer_the_same(name, answers, tmp_path, monkeypatch) -> None:
    spelling = SPELLINGS[name]
    alone = answers(spelling, stored=False)
    monkeypatch.setattr(many, "WORTH_WORKERS", 0.0)
    assert answers(spelling, "--workers", "2") == alone
    assert len(list((tmp_path / "rows" / many.RECORDS).glob("*.lines"))) > 1
    assert answers(spelling) == alone


def test_a_folder_for_one_scene_with_one_load_case_is_refused(command, tmp_path) -> None:
    said = command.refused("solve", "two-balls", "--store", str(tmp_path / "rows"))
    assert "--store: got this option for a scene with one load case" in said
    assert not (tmp_path / "rows").exists()
