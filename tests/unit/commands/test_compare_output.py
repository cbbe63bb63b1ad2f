"""What compare prints and writes: verdict, one table that fits, no row of the reference against itself."""

import csv
import io
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from rich.console import Console

from compare.commands.compare_output import beside, is_itself, table, verdict, write_files
from compare.models.comparison import Loads
from compare.reference.estimate import Reference
from compare.scenes import catalogue
from meshes.parts import Scene


def loads(scene: Scene, model: str, factor: float) -> Loads:
    n = scene.ball_count
    load = np.zeros((n, 4))
    load[:, [0, 3]] = (200.0 + np.arange(n)[:, None]) * factor
    angle = np.where(load > 0.0, 45.0, np.nan)
    stations = np.array([0.0, scene.screw.length])
    return Loads(model, load, angle, stations, np.array([[0.0, 0.0, 1e-5]] * 2) * factor, 1.0)


@pytest.fixture
def compared() -> tuple[Scene, list[Any], Reference, Any]:
    scene = catalogue.scene("lin-case1")
    own = loads(scene, "3D reference", 1.0)
    runs = cast("Any", (SimpleNamespace(level=1),))
    found = Reference(scene.name, runs, own.load, None, None, None, None)
    models = [beside(scene, loads(scene, name, f), found) for name, f in (("refined", 1.01), ("lin-source-partition", 0.9))]
    return scene, models, found, beside(scene, own, None)


def test_the_verdict_speaks_of_the_default_model_and_of_one_level(compared: Any) -> None:
    _, models, found, _ = compared
    text = verdict(models, found)
    assert text.startswith("refined is off by 1.07 % of the mean load on the worst contact (ball 32")
    assert "one level gives no uncertainty" in text


def test_the_table_fits_80_columns_with_the_reference_first(compared: Any) -> None:
    _, models, _, itself = compared
    stream = io.StringIO()
    Console(file=stream, width=80).print(table(models, itself))
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    assert [line.split()[0] for line in lines] == ["model", "3D", "refined", "lin-source-partition"]
    assert "…" not in stream.getvalue()


def test_the_run_that_is_the_reference_is_no_row(compared: Any) -> None:
    scene, _, found, _ = compared
    assert is_itself(loads(scene, "3D level 1", 1.0), found)
    assert not is_itself(loads(scene, "3D source mesh", 1.0), found)


def test_every_contact_is_written_beside_its_reference(compared: Any, tmp_path: Path) -> None:
    scene, models, found, _ = compared
    said = write_files(scene, models, found, tmp_path)
    rows = list(csv.DictReader((tmp_path / "lin-case1-compare.csv").read_text().splitlines()))
    assert len(rows) == 2 * scene.ball_count
    assert float(rows[0]["refined_N"]) == pytest.approx(1.01 * float(rows[0]["reference_N"]))
    assert rows[0]["uncertainty_N"] == ""
    assert (tmp_path / "lin-case1-compare.svg").stat().st_size > 1000
    assert "lin-case1-compare.csv" in said
