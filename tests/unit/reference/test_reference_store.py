"""Stored runs of the 3D reference and condensed bodies: keys, damage, what serves in place of what."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from tests.reference_records import bodies_of, run_of

from rollbench.compare.reference import jobs, levels, store, tasks
from rollbench.compare.reference.store import content_key_of_run, load_stored_run, path_of_bodies, path_of_run, save_run
from rollbench.compare.scenes import catalogue
from rollbench.meshes import condensed, solid

CASE1 = catalogue.scene("lin-case1")


def test_round_trip_and_damage(tmp_path) -> None:
    loads = np.arange(128.0).reshape(32, 4)
    run = run_of("lin-case1", 2, loads)
    file = save_run(tmp_path, CASE1, run)
    assert file == path_of_run(tmp_path, CASE1, run)
    back = load_stored_run(CASE1, 2, stores=(tmp_path,))
    assert np.array_equal(back.load, loads)
    assert np.array_equal(back.without["elastic nut"], loads)
    assert np.isnan(back.angle).all()
    assert (back.setup_seconds, back.sides, back.assumed, back.settings) == (3.0, (0, 3), ("nothing",), run.settings)
    assert load_stored_run(CASE1, 1, stores=(tmp_path,)) is None
    whole = file.read_text()
    modes = levels.LEVELS[2]["modes"]
    other = whole.replace(f'"modes":{modes}', f'"modes":{modes + 1}')
    assert other != whole
    for damaged in (whole[:100], whole.replace('"load":[[', '"load":[[1],['), "[]", "", other):
        file.write_text(damaged)
        assert load_stored_run(CASE1, 2, stores=(tmp_path,)) is None
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


def test_a_run_is_found_by_content_under_any_name(tmp_path) -> None:
    copy, heavier = replace(CASE1, name="my [copy]", title="x"), replace(CASE1, loads=())
    save_run(tmp_path, CASE1, run_of("lin-case1", 2, np.ones((32, 4))))
    found = load_stored_run(copy, 2, stores=(tmp_path,))
    assert (found.scene, found.load.sum()) == ("lin-case1", 128.0)
    assert load_stored_run(copy, 1, stores=(tmp_path,)) is None
    assert load_stored_run(replace(heavier, name="lin-case1"), 2, stores=(tmp_path,)) is None
    (tmp_path / "lin-case1-level2-0123456789abcdef.json").write_text("{}")
    save_run(tmp_path, copy, replace(run_of("lin-case1", 2, 2.0 * np.ones((32, 4))), scene="my [copy]"))
    assert load_stored_run(copy, 2, stores=(tmp_path,)).load.sum() == 256.0, "of equal ones that under the scene's own name"
    assert load_stored_run(CASE1, 2, stores=(tmp_path,)).load.sum() == 128.0


def test_key_follows_the_content_not_the_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything that a run's numbers depend on changes its key; names and remarks do not."""
    mesh, sides = asdict(tasks.mesh_settings([CASE1], 1)), (0, 3)
    key = content_key_of_run(CASE1, "", mesh, sides)
    assert content_key_of_run(replace(CASE1, title="other", assumed=(), name="x"), "", mesh, sides) == key
    assert content_key_of_run(CASE1, "", mesh | {"cuts": list(mesh["cuts"]), "semi": list(mesh["semi"])}, [0, 3]) == key
    longer, other = replace(CASE1.nut, length=0.055), replace(CASE1.solid, shaft=0.03)
    found = [
        content_key_of_run(replace(CASE1, **x), "", mesh, sides) for x in ({"nut": longer}, {"solid": other}, {"loads": ()})
    ]
    found += [
        content_key_of_run(CASE1, "", asdict(tasks.mesh_settings([CASE1], 2)), sides),
        content_key_of_run(CASE1, "land", mesh, sides),
    ]
    found += [
        content_key_of_run(CASE1, "", mesh, (0, 1, 2, 3)),
        content_key_of_run(CASE1, "", mesh | {"reach": (1e-3, 1e-4)}, sides),
    ]
    assumed = replace(solid.dimensions_of_3d_parts(CASE1), hole=2.0 * solid.dimensions_of_3d_parts(CASE1).hole)
    for name, value in (
        ("program_versions", lambda: {"gmsh": "0", "scikit-fem": "0"}),
        ("SCHEMA", -1),
        ("dimensions_of_3d_parts", lambda _: assumed),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(store, name, value)
            found.append(content_key_of_run(CASE1, "", mesh, sides))
    assert len({key, *found}) == 11


def test_only_converged_runs_are_stored(tmp_path) -> None:
    failed = replace(run_of("lin-case1", 1, np.ones((32, 4))), status="not held: because")
    with pytest.raises(ValueError, match="cannot be a reference: not held: because"):
        save_run(tmp_path, CASE1, failed)
    jobs.store_runs_and_condensed_bodies(tmp_path, tasks.ReferenceTask((CASE1,), 1), [failed], None)
    assert list(tmp_path.iterdir()) == []


def test_a_run_meshed_with_other_scenes_serves_if_its_mesh_does(tmp_path) -> None:
    loads = np.ones((32, 4))
    wide = run_of("lin-case1", 1, loads, group=("lin-case1", "lin-case2"))
    assert wide.settings["reach"] > run_of("lin-case1", 1, loads).settings["reach"]
    narrow = run_of("unseen-short-nut", 1, np.ones((24, 4)))
    save_run(tmp_path, CASE1, wide)
    assert load_stored_run(CASE1, 1, stores=(tmp_path,)) is not None
    for name, factor in (("semi", 1.5), ("reach", 0.5)):  # too coarse cells, too small patches
        other = wide.settings | {name: tuple(factor * x for x in wide.settings[name])}
        assert not tasks.is_mesh_suitable(CASE1, 1, "", other, wide.sides)
    assert not tasks.is_mesh_suitable(CASE1, 1, "", wide.settings, (0, 1, 2))
    assert not tasks.is_mesh_suitable(CASE1, 1, "", wide.settings | {"modes": 24}, wide.sides)
    assert not tasks.is_mesh_suitable(CASE1, 1, "", narrow.settings | {"reach": (1e-4, 1e-5)}, narrow.sides)


def test_sides_that_may_touch() -> None:
    two, four = ("lin-case1", "lin-case2", "unseen-63x20"), ("lin-case3", "lin-profile", "unseen-25x5")
    found = {name: tasks.flanks_to_mesh(catalogue.scene(name)) for name in (*two, *four)}
    assert found == dict.fromkeys(two, (0, 3)) | dict.fromkeys(four, (0, 1, 2, 3))


def test_scenes_of_the_same_parts_share_a_set_up() -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "bearing-9", "lin-case3-offset", "lin-profile")]
    found = [[s.name for s in g] for g in tasks.group_scenes_by_geometry(scenes)]
    assert found == [["lin-case1", "lin-case3-offset", "lin-profile"], ["bearing-9"]]
    assert tasks.values_that_determine_meshes(scenes[0]) != tasks.values_that_determine_meshes(
        replace(scenes[0], solid=replace(scenes[0].solid, nut="rigid"))
    )


def test_condensed_bodies_survive_the_file_and_refuse_a_foreign_one(tmp_path) -> None:
    bodies = bodies_of(CASE1, 2)
    bodies.save(tmp_path / "a.npz")
    read = condensed.read_condensed_bodies(tmp_path / "a.npz")
    assert (read.geometry, read.level, read.base) == (bodies.geometry, 2, 0.3)
    assert np.array_equal(read.screw, bodies.screw)
    (tmp_path / "b.npz").write_bytes((tmp_path / "a.npz").read_bytes()[:-200])
    np.savez(tmp_path / "c.npz", format=99)
    for name, words in (("b", "damaged"), ("c", "format 99")):
        with pytest.raises(ValueError, match=words):
            condensed.read_condensed_bodies(tmp_path / f"{name}.npz")


def test_bodies_are_keyed_by_the_range_of_loads_that_they_were_made_for(tmp_path) -> None:
    """A run under other loads has the same geometry, but its patches' own terms are sampled elsewhere."""
    run = run_of("lin-case1", 1, np.ones((32, 4)))
    heavy = replace(CASE1, loads=(replace(CASE1.loads[0], force=(0.0, 0.0, 60e3)),))
    other = replace(run, settings=asdict(tasks.mesh_settings([heavy], 1)))
    assert path_of_bodies(tmp_path, CASE1, run) != path_of_bodies(tmp_path, heavy, other)
    assert path_of_bodies(tmp_path, CASE1, run) == path_of_bodies(tmp_path, replace(CASE1, name="x"), run)
    assert path_of_bodies(tmp_path, CASE1, run) != path_of_bodies(tmp_path, CASE1, replace(run, sides=(0, 1, 2, 3)))
