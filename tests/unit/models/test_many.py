"""What solves many scenes goes one way: every spelling calls one map, what is stored is stored in one store, and sweep and
table have one set of columns."""

import json
import pickle
from pathlib import Path

import pytest
from tests.load_cases import written

import rollbench
from rollbench.compare.models import many
from rollbench.compare.reference import parallel
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.studies import columns, survey
from rollbench.compare.studies.sweep.run import solve_missing_samples, sweep_definition
from rollbench.compare.studies.table import check_table_request, solve_table

SCENE, VARY = "two-balls", ("errors.balls.oversize=4 um:7 um",)


def sweep(folder: Path):
    return solve_missing_samples(sweep_definition(SCENE, VARY, 3, "lhs", 1, "lin"), folder, ComputingSettings(), print)


def table(folder: Path):
    return rollbench.table(SCENE, ["errors.balls.oversize=4:7:4 um"], quantities=["load"], model="lin", store=folder)


def drawn_screws(folder: Path):
    return survey.solve_screws_of_survey(survey.SEED, 1, folder, 1, print)


SPELLINGS = {
    "load cases": lambda folder: rollbench.solve(written(folder), model="lin"),
    "solve A B": lambda _: rollbench.side_by_side([SCENE, "clearance"], model="lin"),
    "curve": lambda _: rollbench.load_curve(SCENE, "100N:200N:2", "lin"),
    "members": lambda _: rollbench.ensemble("lin-random", 2, model="lin"),
    "sweep": sweep,
    "table": table,
    "own models on drawn screws": lambda _: rollbench.survey("mei", count=12, workers=1),
    "drawn screws in 3D": drawn_screws,
}


class GoneError(Exception):
    """Raised in place of what was taken away."""


def gone(*_: object) -> None:
    raise GoneError


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_no_spelling_solves_without_the_map(spelling, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(many, "_solve_row", gone)
    with pytest.raises(GoneError):
        SPELLINGS[spelling](tmp_path)


@pytest.mark.parametrize("spelling", [sweep, table, drawn_screws])
def test_what_goes_on_after_a_kill_is_stored_in_one_store(spelling, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(many.Store, "is_of_current_run", gone)
    with pytest.raises(GoneError):
        spelling(tmp_path / "runs")


@pytest.mark.parametrize("spelling", [sweep, table])
def test_sweep_and_table_have_one_set_of_columns(spelling, tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(columns.COLUMNS, columns.MAIN, columns.Column("largest contact load / N", gone))
    with pytest.raises(GoneError):
        spelling(tmp_path)


def test_a_table_has_the_same_bytes_whichever_row_is_done_first_and_elsewhere(monkeypatch) -> None:
    def backwards(jobs, *_):
        for k, (function, arguments) in reversed(list(enumerate(jobs))):
            yield k, pickle.loads(pickle.dumps(function(*arguments)))

    request = check_table_request(SCENE, ["errors.balls.oversize=4:7:4 um"], ["load"], "lin")
    alone = solve_table(request, ComputingSettings(), print)
    monkeypatch.setattr(parallel, "run_jobs", backwards)
    shared = solve_table(request, ComputingSettings(parallel_jobs=2), print)
    assert json.dumps(alone.to_dict()) == json.dumps(shared.to_dict())
    assert len({row.load for row in alone.rows}) == 4
