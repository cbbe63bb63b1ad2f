"""Answers of a solved scene: the block of ten entries, its JSON, preload and lift-off, matrix files, the load curve."""

import csv
import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import mmread

from compare.cli import main
from compare.commands.matrix_files import dmig, market
from compare.commands.summary import answers_json, block, entries
from compare.errors import InputError
from compare.models.answers import Answers, gather, tangent_of
from compare.models.loading import lift_off, preload, solve_scaled
from compare.models.model_form import estimate
from compare.models.registry import Options, run_model
from compare.scenes import catalogue
from lowfi.rating.rigidity import slope_of
from lowfi.statics.result import StaticResult
from meshes.parts import BallErrors, Errors, Scene

QUIET = Options(discretisation=False)
LABELS = ("loads", "axial", "contact", "ellipse", "static", "preload", "friction", "life", "error", "assumed")


@pytest.fixture(scope="module")
def solved() -> tuple[Scene, StaticResult, Answers]:
    scene = replace(catalogue.scene("lin-case3"), friction=None)
    result = run_model(scene, "lin", QUIET)
    return scene, result, gather(scene, result, "lin", QUIET)


@pytest.mark.parametrize("width", [60, 80, 100])
def test_the_block_has_ten_entries_and_is_never_wider(solved: tuple[Scene, StaticResult, Answers], width: int) -> None:
    lines = block(*solved, None, width).split("\n")
    assert max(map(len, lines)) <= width
    assert tuple(line.split()[0] for line in lines if not line.startswith(" ")) == LABELS


def test_what_is_not_covered_is_said_without_a_doubled_label(solved: tuple[Scene, StaticResult, Answers]) -> None:
    scene, result, found = solved
    uncovered = replace(estimate(scene, result), percent=None)
    assert dict(entries(scene, result, found, uncovered))["error"].startswith("not covered by the comparisons")


def test_the_json_holds_the_numbers_of_the_result(solved: tuple[Scene, StaticResult, Answers]) -> None:
    scene, result, found = solved
    data = json.loads(json.dumps(answers_json(scene, result, found), allow_nan=False))
    assert data["loads"]["max_N"] == pytest.approx(result.load.max())
    assert data["loads"]["mean_N"] == pytest.approx(result.load[result.load > 0].mean())
    assert data["axial"]["force_N"] == pytest.approx(5000.0)
    assert data["axial"]["rigidity_N_per_um"] == data["rigidities_N_per_um"]["with_unequal_loads"]
    # by pressure, which the screw's flank has more of at the same force
    assert data["worst_contact"]["side"].startswith("S")
    assert data["worst_contact"]["force_N"] == pytest.approx(data["loads"]["max_N"], rel=1e-3)
    assert data["friction"] is None
    assert "--mu" in data["friction_words"]
    alone, tangent = data["rigidities_N_per_um"]["contacts_alone"], data["axial"]["tangent_N_per_um"]
    assert 0.5 * alone < tangent < 1.5 * alone


def test_preload_is_what_the_flanks_press_without_load(solved: tuple[Scene, StaticResult, Answers]) -> None:
    scene, _, found = solved
    bare = solve_scaled(scene, 0.0, "lin", QUIET)
    held = preload(scene, bare)
    assert held == found.preload
    assert held.loaded == 4 * scene.ball_count
    assert held.axial == pytest.approx(slope_of(scene) * bare.load[:, 0].sum(), rel=0.02)


def test_the_first_contact_is_lost_where_lift_off_says(solved: tuple[Scene, StaticResult, Answers]) -> None:
    scene, _, found = solved
    assert found.lift is not None
    assert found.lift.factor is not None
    before, after = (solve_scaled(scene, f * found.lift.factor, "lin", QUIET) for f in (0.98, 1.02))
    assert before.load.min() > 0.0
    assert after.load[found.lift.ball - 1, ["SL", "SR", "NL", "NR"].index(found.lift.side)] == 0.0
    assert found.lift.axial == pytest.approx(5000.0 * found.lift.factor)


def test_lift_off_below_the_scenes_load_and_without_preload() -> None:
    scene = replace(catalogue.scene("lin-case3"), errors=Errors(balls=BallErrors(oversize=2e-6)))
    result, bare = run_model(scene, "lin", QUIET), solve_scaled(scene, 0.0, "lin", QUIET)
    found = lift_off(scene, result, bare, "lin", QUIET)
    assert found is not None
    assert found.factor is not None
    assert 0.0 < found.factor < 1.0
    assert solve_scaled(scene, 0.97 * found.factor, "lin", QUIET).load.min() > 0.0
    assert solve_scaled(scene, 1.03 * found.factor, "lin", QUIET).load.min() == 0.0
    plain = catalogue.scene("lin-case1")
    assert lift_off(plain, result, solve_scaled(plain, 0.0, "lin", QUIET), "lin", QUIET) is None


def test_matrix_files_hold_the_matrix() -> None:
    rng = np.random.default_rng(1)
    a = rng.normal(size=(6, 6)) * 1e6
    matrix = a @ a.T
    np.testing.assert_allclose(mmread(io.StringIO(market(matrix, "a"))), matrix, rtol=1e-14)
    read = np.zeros((6, 6))
    column = -1
    for line in dmig(matrix, "a comment").splitlines():
        if line.startswith("DMIG*"):
            column = int(line[40:56]) - 1
        elif line.startswith("*"):
            row = int(line[24:40]) - 1
            read[row, column] = read[column, row] = float(line[40:56].replace("D", "E"))
    np.testing.assert_allclose(read, matrix, rtol=1e-9)


def test_a_model_without_bodies_has_no_tangent() -> None:
    with pytest.raises(InputError, match="mei"):
        tangent_of(catalogue.scene("lin-case1"), 0.4, "mei", QUIET)


def test_curve_and_matrix_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    curve, matrix = tmp_path / "curve.csv", tmp_path / "k.mtx"
    tokens = [
        "solve",
        "bearing-9",
        "--model",
        "lin",
        "--curve",
        str(curve),
        "--stiffness-at",
        "8 mm",
        "--matrix",
        str(matrix),
    ]
    with pytest.raises(SystemExit) as stop:
        main(tokens)
    out = capsys.readouterr().out
    assert not stop.value.code
    rows = list(csv.DictReader(curve.read_text().splitlines()))
    assert len(rows) == 16
    assert float(rows[10]["axial_force_N"]) == pytest.approx(2963.065, rel=1e-4)
    moved = [float(row["displacement_um"]) for row in rows]
    assert moved == sorted(moved)
    assert (tmp_path / "curve.svg").read_text().startswith("<?xml")
    assert mmread(matrix).shape == (6, 6)
    assert "tangent stiffness" in out
    assert "no torque: the scene has no coefficient of friction" in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 100


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--matrix", "k.mtx"), "--stiffness-at"),
        (("--stiffness-at", "8 mm", "--matrix", "k.txt"), ".dmig"),
        (("--stiffness-at", "9 m"), "16 mm"),
        (("--stiffness-at", "8 kg"), "--stiffness-at"),
        (("--curve", "x.txt"), ".csv"),
    ],
)
def test_options_that_do_not_go_together_are_one_line(
    more: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["solve", "bearing-9", *more])
    err = capsys.readouterr().err
    assert stop.value.code == 2
    assert err.count("\n") == 1
    assert words in err


@pytest.mark.parametrize(
    "words",
    [("solve", "two-balls", "--model", "lin", "--balls"), ("friction", "two-balls", "--model", "lin", "--mu", "0.1")],
)
def test_a_pipe_gets_plain_text_without_rules(words: tuple[str, ...]) -> None:
    """No box-drawing, no colours, no line wider than 100."""
    out = subprocess.run(
        [sys.executable, "-P", "-m", "compare", *words],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "FORCE_COLOR": ""},
    ).stdout
    assert not any(c in out for c in "┃│━─\x1b")
    assert max(map(len, out.splitlines())) <= 100
