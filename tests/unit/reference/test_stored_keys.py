"""The key of every run, body and roller that is shipped is built from its scene: none is renamed or computed again."""

import json
import re
from pathlib import Path

import pytest

from rollbench.compare.reference import store
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies import roller
from rollbench.compare.studies.rolling import runs as rolling

#: Names of all stored files when the list was written; each ends with its key.
STORED = Path(__file__).with_name("stored_runs.txt").read_text(encoding="utf-8").split()
FOLDER = store.shipped_store()
RUNS = [name for name in STORED if name.endswith(".json") and not name.startswith(("rolling-", "roller-"))]


def run_of_file(name: str) -> tuple[object, store.Run | None]:
    """Scene that a stored file names, and its run if the key of the scene is that of the file."""
    data = store.read_checked_data(FOLDER / name)
    scene = catalogue.shipped_scene(data["scene"])
    return scene, store.read_run_file(FOLDER / name, scene, data["level"], data["variant"])


def test_the_list_has_every_stored_file() -> None:
    assert sorted(path.name for path in FOLDER.iterdir() if re.search(r"-level\d-", path.name)) == STORED
    assert (len(RUNS), len(STORED)) == (139, 271)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_is_found_by_the_key_of_its_scene(name: str) -> None:
    scene, run = run_of_file(name)
    assert run is not None
    assert store.path_of_run(FOLDER, scene, run).name == name
    assert FOLDER / name in store.files_of_stored_runs(FOLDER, scene, run.level, run.variant)


def test_every_stored_body_has_the_key_of_a_scene() -> None:
    found = [run_of_file(name) for name in RUNS]
    of_one_nut = [(scene, run) for scene, run in found if not hasattr(scene, "sets")]
    bodies = {store.path_of_bodies(FOLDER, scene, run).name for scene, run in of_one_nut}
    assert {name for name in STORED if name.startswith("bodies-")} <= bodies


def test_rolling_runs_and_rollers_have_the_keys_of_their_scenes() -> None:
    found = set()
    for name in (name for name in STORED if name.startswith("rolling-")):
        data = json.loads((FOLDER / name).read_text(encoding="utf-8"))
        scene = catalogue.shipped_scene(data["scene"])
        found.add(rolling.rolling_run_path(FOLDER, scene, data["level"], data.get("bodies", rolling.HALF_SPACE)).name)
    axis = catalogue.shipped_scene("smith-axis-taper")
    for kind in roller.roller_kinds_with_largest_load(axis):
        found |= {roller.roller_run_file_name(kind, level) for level in roller.LEVELS}
    assert found == {name for name in STORED if name.startswith(("rolling-", "roller-"))}
