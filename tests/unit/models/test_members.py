"""Members of a scene and of several sets on one shaft: brute force, closed-form moments, own draws of each set, the same
numbers whatever the number of workers."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate
from scipy.stats import binom, norm
from tests.axes import fixed_axis
from tests.helpers import with_ingredients

from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.stiffness import stiffness_of_scene
from rollbench.compare.results.data import output_statistics
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.compare.studies.members import ensemble, members
from rollbench.lowfi.statics.axis.system import ball_positions_with_errors
from rollbench.meshes.errors import scene_without_random_errors
from rollbench.meshes.parts import BallErrors, Load

RANDOM = catalogue.scene("lin-random")


def member_of(scene, member=0):
    return run_model(scene, "lin", ModelOptions(member=member, estimate_beam_mesh_error=False))


def solved(parts, count, model="lin"):
    return members.solve_random_draws_of_scene(parts, model, count)


def test_members_are_the_single_solves():
    found = solved(RANDOM, 5)
    loads, spread = np.stack([member_of(RANDOM, m).load for m in range(5)]), found.load_distributions
    for name, of in (("mean_loads", np.mean), ("largest", np.max), ("smallest_loads", np.min)):
        np.testing.assert_allclose(getattr(spread, name), of(loads, axis=0), rtol=1e-11, err_msg=name)
    np.testing.assert_allclose(spread.standard_deviation, loads.std(axis=0, ddof=1), rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(found.outputs[:, 0], loads.max(axis=(1, 2)), rtol=1e-12)
    off = np.abs(spread.load_quantiles(0.5) - np.median(loads, axis=0))
    assert (off[loads[0] > 0.0] <= spread.width).all()
    assert not found.status_of_failed_draws


def test_moments_of_balls_between_rigid_rings():
    # rings that stand: the load of each ball depends on its own radius alone, F = ((t + 2 e) / (C_a + C_b))^1.5
    base = catalogue.scene("two-balls")
    ((support,), sigma, count) = base.supports, 1e-6, 150
    held = replace(support, fixed=tuple((name, 0.0 if name == "ux" else value) for name, value in support.fixed))
    errors = replace(base.errors, balls=BallErrors(oversize=1e-6, sigma=sigma))
    scene = with_ingredients(replace(base, supports=(held,), errors=errors), hertz="error-free")
    spread = solved(scene, count).load_distributions
    bare = member_of(scene_without_random_errors(scene))
    ball, side = np.unravel_index(bare.load.argmax(), bare.load.shape)
    both = bare.hertz_C[ball, side] + bare.hertz_C[ball, 3 - side]
    start = both * bare.load[ball, side] ** (2.0 / 3.0)

    def moment(power):
        def weighted(e):
            return (max(start + 2.0 * e, 0.0) / both) ** (1.5 * power) * norm.pdf(e, scale=sigma)

        return integrate.quad(weighted, -8.0 * sigma, 8.0 * sigma, limit=200)[0]

    mean, deviation = moment(1), np.sqrt(moment(2) - moment(1) ** 2)
    assert abs(spread.mean_loads[ball, side] - mean) < 4.0 * deviation / np.sqrt(count)
    assert spread.standard_deviation[ball, side] == pytest.approx(deviation, rel=4.0 / np.sqrt(2.0 * count))
    assert mean != pytest.approx(bare.load[ball, side], rel=1e-3)


def test_life_of_equal_loads_goes_with_their_cube():
    load, life = np.zeros((8, 4)), ensemble.raceway_life_measure
    load[:, 0] = load[:, 3] = 100.0
    assert (life(2.0 * load) / life(load)) ** -0.9 == pytest.approx(1.0 / 8.0)
    assert life(load * np.repeat([1.5, 0.5], 4)[:, None]) > life(load)


def test_intervals_of_quantiles_cover():
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(300):
        found = output_statistics(rng.normal(size=200), intervals=True)
        low, high = found.intervals[0.95]
        assert low <= found.quantiles[0.95] <= high
        hits += low <= norm.ppf(0.95) <= high
    assert hits >= binom.ppf(0.001, 300, 0.95)


TILTED = Load(0.0, (0.0, 400.0, 3000.0))
STIFF_SCENES = {
    "load beside the nut": RANDOM,
    "two forces": replace(RANDOM, loads=(*RANDOM.loads, TILTED)),
    "force across": replace(RANDOM, loads=(Load(RANDOM.screw.length, (0.0, 500.0, 0.0)),)),
    "preload only": replace(
        RANDOM, loads=(), errors=replace(RANDOM.errors, balls=replace(RANDOM.errors.balls, oversize=4e-6))
    ),
    "bearing": catalogue.scene("bearing-9-preload"),
}


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize("name", STIFF_SCENES)
def test_members_have_the_stiffness_of_the_nut_and_of_the_load_point(name, model):
    """Both are those of `stiffness_of_scene`, within the curvature of the small change of the loads to one side."""
    scene = STIFF_SCENES[name]
    scene = replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, sigma=0.5e-6)))
    found = solved(scene, 3, model)
    names = ensemble.output_names_of_draw(scene)
    for k in range(3):
        options = ModelOptions(member=k, estimate_beam_mesh_error=False)
        result, bare = (run_model(x, model, options) for x in (scene, with_scaled_loads(scene, 0.0)))
        expected = stiffness_of_scene(scene, result, bare, model, options)
        for key, tangent in (("nut", expected.nut.tangent), ("load_point", expected.load_point.tangent)):
            value = found.outputs[k][names.index(f"{key}_tangent_N_per_um")]
            if tangent is None:
                assert np.isnan(value)
            else:
                assert value == pytest.approx(1e-6 * tangent, rel=1e-4)


SIGMA_OF_SETS = BallErrors(sigma=0.5e-6)


def text_of_sets(said=""):
    """The double nut with random radii of balls on each nut, and what else is said of their errors."""
    first, second, third = shipped_scene_text("double-nut").partition('[[sets]]\nname = "nut 2"')
    random = f'\n{said}\n[sets.errors.balls]\nsigma = "0.5 um"\n\n'
    return first + random + second + third + random


def drawn_sets(parts):
    sets = [replace(s, parts=replace(s.parts, errors=replace(s.parts.errors, balls=SIGMA_OF_SETS))) for s in parts.sets]
    return ensemble.with_error_seed(replace(parts, sets=tuple(sets)), 0)


def test_members_of_several_sets_are_the_single_solves():
    parts = drawn_sets(fixed_axis((0.0, 0.0, 500.0)))
    found = solved(parts, 3)
    results, spread = [run_model(parts, "lin", ModelOptions(member=m)) for m in range(3)], found.load_distributions
    loads = np.stack([ensemble.contact_loads_of_all_balls(r) for r in results])
    np.testing.assert_allclose(spread.mean_loads, loads.mean(axis=0), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(spread.largest, loads.max(axis=0), rtol=1e-9, atol=1e-9)
    member = dict(zip(ensemble.output_names_of_draw(parts), found.outputs[2], strict=True))
    expected = {"largest_load_N": loads[2].max()}
    tangent = stiffness_of_scene(parts, results[2], results[2], "lin", ModelOptions(member=2)).load_point.tangent
    assert member["load_point_tangent_N_per_um"] == pytest.approx(1e-6 * tangent, rel=1e-6)
    for i, (s, place) in enumerate(zip(results[2].sets, ensemble.ball_slices(parts), strict=True)):
        assert np.array_equal(loads[2][place], s.balls.load)
        lives = [ensemble.raceway_life_measure(load) for load in (s.balls.load, spread.nominal[place])]
        expected |= {f"set {i + 1} axial_force_N": s.force[2], f"set {i + 1} relative_life": (lives[0] / lives[1]) ** -0.9}
    assert {name: member[name] for name in expected} == pytest.approx(expected, rel=1e-12)
    assert not found.status_of_failed_draws


def test_sets_draw_errors_of_their_own(tmp_path):
    for said, alike in (("", False), ("[sets.errors]\nseed = 0\n", True)):
        file = tmp_path / f"{alike}.toml"
        file.write_text(text_of_sets(said))
        one, other = ball_positions_with_errors(catalogue.scene_of_any_kind(str(file)), member=3)
        assert np.array_equal(one[1].ball_radii, other[1].ball_radii) == alike


def test_the_command_gives_statistics_of_each_set(tmp_path, command):
    file, rows = tmp_path / "small.toml", tmp_path / "rows.csv"
    file.write_text(text_of_sets().replace("count = 68", "count = 8").replace("turns = 4.3", "turns = 1.5"))
    words = "solve", file, "--members", "3", "--model", "lin"
    data = command.answer(*words, "--csv", rows)
    assert (data["seed"], [s["name"] for s in data["sets"]]) == ([0, 1], ["nut 1", "nut 2"])
    assert {(row["set"], row["index"]) for row in data["balls"]} == {(k, i) for k in (1, 2) for i in range(1, 9)}
    table = list(csv.DictReader(rows.read_text(encoding="utf-8").splitlines()))
    values = [float(r["set 2 mean_load_N"]) for r in table]
    assert data["sets"][1]["statistics"]["mean_load_N"]["mean"] == pytest.approx(np.mean(values), rel=1e-12)
    assert command.answer(*words, "--seed", "7")["seed"] == [7, 8]
