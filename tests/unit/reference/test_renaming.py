"""Stores of version 0.4.4 and before: every file gets its name of today, none is lost, whatever happens."""

import shutil
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from tests.reference_records import bodies_of, run_of

from rollbench.comparison.reference.store import ARRAYS, Run, bodies_path, load, path_in, save, shipped_store, versions
from rollbench.comparison.renaming import __main__ as program
from rollbench.comparison.renaming import old_keys
from rollbench.comparison.renaming.files import ALONE, DAMAGED, TAKEN, UNKNOWN, rename
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.catalogue import scene_text
from rollbench.comparison.wings.rolling import runs
from rollbench.meshes.condensed import geometry_digest, load_condensed
from rollbench.meshes.parts import Scene

SCENE = catalogue.scene("lin-case1")
ROLLING = catalogue.shipped("lin-pair-a")


def old_store(folder: Path, scene: Scene = SCENE) -> Run:
    """A store as version 0.4.4 wrote it: two runs of a scene, their bodies, and one of rolling."""
    loads = np.arange(128.0).reshape(32, 4)
    run = replace(run_of("lin-case1", 1, loads), scene=scene.name, versions=versions())
    held = old_keys.geometry_digest(scene)
    for one in (run, replace(run, variant="land")):
        path = save(folder, scene, one)
        key = old_keys.run_key(scene, one.variant, asdict(one)["settings"], one.sides)
        path.rename(path.with_name(f"{path.stem[:-16]}{key}.json"))
    key = old_keys.bodies_key(scene, run.settings, run.sides)
    replace(bodies_of(scene, 1), geometry=held).save(folder / f"bodies-{held}-level1-{key}.npz")
    replace(bodies_of(scene, 1), geometry=held).save(folder / "mine.npz")
    (kept,) = (p for p in shipped_store().glob("rolling-lin-pair-a-level1-*.json"))
    shutil.copy(kept, folder / f"rolling-lin-pair-a-level1-{old_keys.rolling_key(ROLLING, 1, 'half-space')}.json")
    return run


def check(folder: Path, scene: Scene, run: Run) -> None:
    """Everything is found, as it was written, and nothing else is there."""
    for variant in ("", "land"):
        found = load(scene, 1, variant, (folder,))
        assert found is not None
        assert all(np.array_equal(getattr(found, name), getattr(run, name), equal_nan=True) for name in ARRAYS)
    bodies = bodies_path(folder, scene, run)
    for path in (bodies, folder / "mine.npz"):
        held = load_condensed(path)
        assert held.geometry == geometry_digest(scene)
        assert np.array_equal(held.screw, bodies_of(scene, 1).screw)
    assert runs.load(ROLLING, 1, (folder,)) == runs.load(ROLLING, 1, (shipped_store(),))
    paths = [path_in(folder, scene, one) for one in (run, replace(run, variant="land"))]
    expected = {*paths, bodies, folder / "mine.npz", runs.path_in(folder, ROLLING, 1)}
    assert set(folder.iterdir()) == expected


def test_old_names_are_found_once_renamed_and_again(tmp_path: Path) -> None:
    run = old_store(tmp_path)
    assert load(SCENE, 1, "", (tmp_path,)) is None
    first, again = rename(tmp_path, [SCENE, ROLLING]), rename(tmp_path, [SCENE, ROLLING])
    assert (len(first.done), first.new, first.left) == (4, ["mine.npz"], {})
    assert (again.done, len(again.new), again.left) == ([], 5, {})
    check(tmp_path, SCENE, run)


def test_a_user_s_store_is_renamed_with_the_scene_s_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "own.toml").write_text(scene_text("lin-case1"))
    scene = catalogue.scene(str(tmp_path / "own.toml"))
    folder = tmp_path / "rollbench-reference"
    folder.mkdir()
    run = old_store(folder, scene)
    assert program.main([str(folder)]) == 1
    assert f"{scene.name}-level1-" in capsys.readouterr().out
    assert program.main([str(folder), str(tmp_path / "own.toml")]) == 0
    assert program.main([str(folder), str(tmp_path / "own.toml")]) == 0
    check(folder, scene, run)
    assert program.main([str(tmp_path / "none")]) == 2
    assert "allowed: a folder of stored runs" in capsys.readouterr().err


def test_damaged_foreign_and_lone_files_stay_as_they_are(tmp_path: Path) -> None:
    old_store(tmp_path)
    plain, land = sorted(tmp_path.glob("lin-case1-*.json"), key=lambda p: "land" in p.name)
    plain.write_text(plain.read_text().replace("1.0", "1.5", 1))
    land.rename(land.with_name(f"{land.stem[:-16]}{'0' * 16}.json"))
    before = {p.name: p.read_bytes() for p in tmp_path.glob("lin-case1-*.json")} | {
        p.name: p.read_bytes() for p in tmp_path.glob("bodies-*")
    }
    found = rename(tmp_path, [SCENE, ROLLING])
    reasons = {plain.name: DAMAGED, **{name: UNKNOWN if "land" in name else ALONE for name in before if name != plain.name}}
    assert found.left == reasons
    assert {name: (tmp_path / name).read_bytes() for name in before} == before


@pytest.mark.parametrize("moment", range(8))
def test_nothing_is_lost_when_interrupted(moment: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, calls = old_store(tmp_path), iter(range(100))

    def counted(real):
        def call(*arguments, **named):
            if next(calls) == moment:
                raise KeyboardInterrupt
            return real(*arguments, **named)

        return call

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", counted(__import__("os").replace))
        patch.setattr(Path, "unlink", counted(Path.unlink))
        try:
            rename(tmp_path, [SCENE, ROLLING])
        except KeyboardInterrupt:
            pass
        else:
            assert moment > 5
    for path in tmp_path.glob(".*"):
        path.unlink()
    assert rename(tmp_path, [SCENE, ROLLING]).left == {}
    check(tmp_path, SCENE, run)


def test_another_run_of_the_new_name_is_kept(tmp_path: Path) -> None:
    run = old_store(tmp_path)
    made_since = save(tmp_path, SCENE, replace(run, date="2027-01-01"))
    found = rename(tmp_path, [SCENE, ROLLING])
    assert list(found.left.values()) == [TAKEN]
    assert "2027-01-01" in made_since.read_text()


def test_old_keys_are_those_of_version_0_4_4() -> None:
    """Names of files as that version shipped them."""
    scene = catalogue.scene("lin-case3-offset")
    run, land = load(scene, 2), load(catalogue.scene("lin-case3"), 1, "land")
    assert run is not None
    assert land is not None
    assert old_keys.run_key(scene, "", run.settings, run.sides) == "84aa4281e06eca5c"
    assert old_keys.run_key(catalogue.scene("lin-case3"), "land", land.settings, land.sides) == "9a192aac8b3cb85a"
    assert old_keys.geometry_digest(scene) == "5632eb2d2c66790a"
    assert old_keys.bodies_key(scene, run.settings, run.sides) == "832901ec27bbda14"
    assert old_keys.rolling_key(ROLLING, 1, "finite") == "ff49cd5cbd8595b8"
    assert old_keys.rolling_key(catalogue.shipped("lin-rotary-1"), 2, "half-space") == "794e5d7981ddfa17"
    assert old_keys.rolling_key(catalogue.shipped("lin-screw-pair-a"), 3, "half-space") == "262f502a2ff5775f"


@pytest.mark.slow
def test_every_shipped_file_has_the_name_of_today(tmp_path: Path) -> None:
    shutil.copytree(shipped_store(), tmp_path / "copy")
    found = rename(tmp_path / "copy", [catalogue.shipped(name) for name in catalogue.scene_names()])
    assert (found.done, found.left) == ([], {})
    assert len(found.new) == len(list(shipped_store().glob("*-level*")))
