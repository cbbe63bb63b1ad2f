"""Stored runs of the 3D reference and condensed bodies: keys, damage, what serves in place of what."""

from dataclasses import asdict, fields, replace

import numpy as np
import pytest
from tests.reference_records import run_of

from rollbench.compare.reference import levels, store, tasks
from rollbench.compare.reference.store import content_key_of_run, load_stored_run, path_of_bodies, save_run
from rollbench.compare.scenes import catalogue
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes import condensed, solid

CASE1 = catalogue.scene("lin-case1")


def test_round_trip_and_damage(tmp_path) -> None:
    loads = np.arange(128.0).reshape(32, 4)
    run = run_of("lin-case1", 2, loads)
    file = save_run(tmp_path, CASE1, run)
    back = load_stored_run(CASE1, 2, stores=(tmp_path,))
    assert np.array_equal(back.load, loads)
    assert np.array_equal(back.without["elastic nut"], loads)
    assert np.isnan(back.angle).all()
    assert (back.setup_seconds, back.sides, back.assumed, back.settings) == (3.0, (0, 3), ("nothing",), run.settings)
    assert load_stored_run(CASE1, 1, stores=(tmp_path,)) is None
    whole, modes = file.read_text(), levels.LEVELS[2]["modes"]
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
    first, second = (asdict(tasks.mesh_settings([CASE1], level)) for level in (1, 2))

    def key(variant="", mesh=first, sides=(0, 3), **changes):
        return content_key_of_run(replace(CASE1, **changes), variant, mesh, sides)

    assert key(title="other", assumed=(), name="x") == key()
    assert key(mesh=first | {"cuts": list(first["cuts"]), "semi": list(first["semi"])}, sides=[0, 3]) == key()
    found = [
        key(),
        key(nut=replace(CASE1.nut, length=0.055)),
        key(solid=replace(CASE1.solid, shaft=0.03)),
        key(loads=()),
        key("land"),
        key(mesh=second),
        key(mesh=first | {"reach": (1e-3, 1e-4)}),
        key(sides=(0, 1, 2, 3)),
    ]
    dims = solid.dimensions_of_3d_parts(CASE1)
    for name, value in (
        ("program_versions", lambda: {"gmsh": "0", "scikit-fem": "0"}),
        ("SCHEMA", -1),
        ("dimensions_of_3d_parts", lambda _: replace(dims, hole=2.0 * dims.hole)),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(store, name, value)
            found.append(key())
    assert len(set(found)) == 11


def test_a_run_meshed_with_other_scenes_serves_if_its_mesh_does(tmp_path) -> None:
    loads = np.ones((32, 4))
    wide = run_of("lin-case1", 1, loads, group=("lin-case1", "lin-case2"))
    mesh = wide.settings
    assert mesh["reach"] > run_of("lin-case1", 1, loads).settings["reach"]
    save_run(tmp_path, CASE1, wide)
    assert load_stored_run(CASE1, 1, stores=(tmp_path,)) is not None
    coarser, smaller = (tuple(k * x for x in mesh[name]) for name, k in (("semi", 1.5), ("reach", 0.5)))
    for other in (mesh | {"semi": coarser}, mesh | {"reach": smaller}, mesh | {"modes": 24}):
        assert not tasks.is_mesh_suitable(CASE1, 1, "", other, wide.sides)
    assert not tasks.is_mesh_suitable(CASE1, 1, "", mesh, (0, 1, 2))


def test_sides_that_may_touch() -> None:
    two, four = ("lin-case1", "lin-case2", "unseen-63x20"), ("lin-case3", "lin-profile", "unseen-25x5")
    found = {name: tasks.flanks_to_mesh(catalogue.scene(name)) for name in (*two, *four)}
    assert found == dict.fromkeys(two, (0, 3)) | dict.fromkeys(four, (0, 1, 2, 3))


def test_scenes_of_the_same_parts_share_a_set_up() -> None:
    scenes = [catalogue.scene(n) for n in ("lin-case1", "bearing-9", "lin-case3-offset", "lin-profile")]
    found = [[s.name for s in g] for g in tasks.group_scenes_by_geometry(scenes)]
    assert found == [["lin-case1", "lin-case3-offset", "lin-profile"], ["bearing-9"]]
    rigid = replace(CASE1, solid=replace(CASE1.solid, nut="rigid"))
    assert tasks.values_that_determine_meshes(CASE1) != tasks.values_that_determine_meshes(rigid)


def test_condensed_bodies_of_another_format_are_refused(tmp_path) -> None:
    np.savez(tmp_path / "c.npz", format=99)
    with pytest.raises(ValueError, match="format 99"):
        condensed.read_condensed_bodies(tmp_path / "c.npz")


def test_bodies_are_keyed_by_the_range_of_loads_that_they_were_made_for(tmp_path) -> None:
    """A run under other loads has the same geometry, but its patches' own terms are sampled elsewhere."""
    run = run_of("lin-case1", 1, np.ones((32, 4)))
    heavy = replace(CASE1, loads=(replace(CASE1.loads[0], force=(0.0, 0.0, 60e3)),))
    other, path = replace(run, settings=asdict(tasks.mesh_settings([heavy], 1))), path_of_bodies(tmp_path, CASE1, run)
    assert path_of_bodies(tmp_path, replace(CASE1, name="x"), run) == path
    assert path_of_bodies(tmp_path, heavy, other) != path
    assert path_of_bodies(tmp_path, CASE1, replace(run, sides=(0, 1, 2, 3))) != path


#: Lengths; all other settings are counts and ratios.
LENGTHS = {"own_sizes", "own_ball_sizes", "fine", "coarse", "ball_fine", "ball_coarse", "cell", "tet"}


@pytest.mark.parametrize("level", [levels.SOURCE_LEVEL, *levels.LEVELS])
def test_lengths_go_with_the_ball_and_counts_and_ratios_stay(level):
    """Twice the ball: the same mesh twice as large; the ball they are given for: as they are."""
    given = levels.SOURCE_MESH if level == levels.SOURCE_LEVEL else levels.LEVELS[level]
    assert levels.mesh_settings_of_level(level, levels.BALL) == given
    twice = levels.mesh_settings_of_level(level, 2.0 * levels.BALL)
    assert twice.keys() == given.keys() <= {x.name for x in fields(Settings)}
    Settings(**twice)
    for name, value in given.items():
        expected = pytest.approx(2.0 * np.array(value)) if name in LENGTHS else value
        assert twice[name] == expected, name
