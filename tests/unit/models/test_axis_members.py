"""Members of several sets on one shaft: brute force, own draws of each set, refusals, what the command prints."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from tests.axes import double_nut, fixed_axis

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.wings.members.blocks import columns, contact_loads, life_sum, with_seed
from rollbench.comparison.wings.members.members import run_members
from rollbench.lowfi.statics.axis.system import placed
from rollbench.meshes.parts import BallErrors

SIGMA = BallErrors(sigma=0.5e-6)
SIGMA_TEXT = '\n[sets.errors.balls]\nsigma = "0.5 um"\n\n'


def drawn(parts):
    sets = [replace(s, parts=replace(s.parts, errors=replace(s.parts.errors, balls=SIGMA))) for s in parts.sets]
    return with_seed(replace(parts, sets=tuple(sets)), 0)


def test_members_are_the_single_solves():
    parts = drawn(fixed_axis((0.0, 0.0, 500.0)))
    found = run_members(parts, "lin", 3)
    results = [run_model(parts, "lin", Options(member=m)) for m in range(3)]
    loads = np.stack([contact_loads(r) for r in results])
    np.testing.assert_allclose(found.bands.mean, loads.mean(axis=0), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.bands.largest, loads.max(axis=0), rtol=1e-9, atol=1e-9)
    names = columns(parts)
    member = dict(zip(names, found.kept[2], strict=True))
    assert member["largest_load_N"] == pytest.approx(loads[2].max(), rel=1e-12)
    assert member["stiffness_N_per_um"] == pytest.approx(1e-6 * results[2].stiffness[2, 2], rel=1e-12)
    for i, (s, place) in enumerate(zip(results[2].sets, found.balls, strict=True)):
        assert member[f"set {i + 1} axial_force_N"] == pytest.approx(s.force[2], rel=1e-12)
        assert np.array_equal(loads[2][place], s.balls.load)
        life = (life_sum(s.balls.load) / life_sum(found.bands.nominal[place])) ** -0.9
        assert member[f"set {i + 1} relative_life"] == pytest.approx(life, rel=1e-12)
    assert not found.failed


def test_sets_draw_errors_of_their_own(tmp_path):
    first, second, third = catalogue.scene_text("double-nut").partition('[[sets]]\nname = "nut 2"')
    for said, alike in (("", False), ("\n[sets.errors]\nseed = 0\n", True)):
        file = tmp_path / f"{alike}.toml"
        file.write_text(first + said + SIGMA_TEXT + second + third + said + SIGMA_TEXT)
        one, other = placed(catalogue.any_scene(str(file)), member=3)
        assert np.array_equal(one[1].ball_radius, other[1].ball_radius) == alike


def test_nothing_random_is_refused():
    for parts, model, count, words in (
        (double_nut(), "lin", 3, "nothing random"),
        (drawn(double_nut()), "mei", 3, "one set"),
        (drawn(double_nut()), "lin", 1, "2 to"),
    ):
        with pytest.raises(InputError, match=words):
            run_members(parts, model, count)


def test_the_command_gives_statistics_of_each_set(tmp_path, command):
    text = catalogue.scene_text("double-nut").replace("count = 68", "count = 8").replace("turns = 4.3", "turns = 1.5")
    first, second, third = text.partition('[[sets]]\nname = "nut 2"')
    file, rows = tmp_path / "small.toml", tmp_path / "rows.csv"
    file.write_text(first + SIGMA_TEXT + second + third + SIGMA_TEXT)
    words = "solve", file, "--members", "3", "--model", "lin"
    code, data = command.json(*words, "--json", "--csv", rows)
    assert (code, data["seed"], [s["name"] for s in data["sets"]]) == (0, [0, 1], ["nut 1", "nut 2"])
    assert {(row["set"], row["index"]) for row in data["balls"]} == {(k, i) for k in (1, 2) for i in range(1, 9)}
    table = list(csv.DictReader(rows.read_text(encoding="utf-8").splitlines()))
    values = [float(r["set 2 mean_load_N"]) for r in table]
    assert data["sets"][1]["statistics"]["mean_load_N"]["mean"] == pytest.approx(np.mean(values), rel=1e-12)
    code, said, _ = command(*words, "--seed", "7")
    assert code == 0
    assert "seed [7, 8]" in said
    assert "set 2, nut 2" in said
