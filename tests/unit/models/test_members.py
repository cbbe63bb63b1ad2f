"""Members of a scene: brute force, closed-form moments, the same numbers whatever the number of workers."""

import csv
import pickle
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy import integrate
from scipy.special import bdtr
from scipy.stats import binom, norm

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.reference.jobs import Engine
from rollbench.comparison.scenes.catalogue import scene as shipped
from rollbench.comparison.wings.members import members
from rollbench.comparison.wings.members.blocks import KEPT, STEP, life_sum
from rollbench.comparison.wings.members.members import LEVELS, _binomial_quantile, run_members, statistics
from rollbench.meshes.errors import without_draws
from rollbench.meshes.parts import BallErrors, FourierTerm, SideErrors

RANDOM = shipped("lin-random")


def with_errors(**errors):
    return replace(RANDOM, errors=replace(RANDOM.errors, **errors))


def member_of(scene, member=0):
    return run_model(scene, "lin", Options(member=member, discretisation=False))


def test_members_are_the_single_solves():
    found = run_members(RANDOM, "lin", 5)
    loads = np.stack([member_of(RANDOM, m).load for m in range(5)])
    for name, of in (("mean", np.mean), ("largest", np.max), ("smallest", np.min)):
        np.testing.assert_allclose(getattr(found.bands, name), of(loads, axis=0), rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(found.bands.deviation, loads.std(axis=0, ddof=1), rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(found.kept[:, 0], loads.max(axis=(1, 2)), rtol=1e-12)
    assert np.all(np.abs(found.bands.quantile(0.5) - np.median(loads, axis=0))[loads[0] > 0.0] <= found.bands.width)
    assert not found.failed


def test_the_mean_load_is_shared_out_over_the_contacts_that_the_screw_without_errors_loads():
    """64 of them, whatever a member loads: here 58 and 54 contacts bear more than a hundredth of the largest load."""
    scene = with_errors(balls=BallErrors(sigma=10e-6))
    found = run_members(scene, "lin", 2).kept[:, list(KEPT).index("mean_load_N")]
    assert found == pytest.approx([member_of(scene, k).load.sum() / 64 for k in range(2)], rel=1e-12)


def test_stiffness_is_that_of_a_small_change_of_the_load():
    found = run_members(RANDOM, "lin", 2)
    (load,) = RANDOM.loads
    shift = []
    for factor in (1.0 - STEP, 1.0 + STEP):
        scene = replace(RANDOM, loads=(replace(load, force=tuple(factor * f for f in load.force)),))
        shift.append(member_of(scene, 1).centreline[0, 2])
    expected = 2.0 * STEP * load.force[2] / (shift[1] - shift[0]) * 1e-6
    assert found.kept[1, 2] == pytest.approx(expected, rel=1e-3)


def test_the_same_numbers_whatever_block_is_done_first(monkeypatch):
    """Blocks done in any order, which travel as those of other processes do; another seed gives other members."""
    alone = run_members(RANDOM, "lin", 12)
    assert not np.array_equal(alone.kept, run_members(with_errors(seed=1), "lin", 12).kept)

    def backwards(jobs, *_):
        numbered = list(enumerate(jobs))
        return iter([(k, pickle.loads(pickle.dumps(function(*arguments)))) for k, (function, arguments) in numbered[::-1]])

    monkeypatch.setattr(members.parallel, "as_done", backwards)
    shared = run_members(RANDOM, "lin", 12, Engine(workers=2))
    assert np.array_equal(alone.kept, shared.kept)
    for name in ("mean", "deviation", "smallest", "largest", "counts"):
        assert np.array_equal(getattr(alone.bands, name), getattr(shared.bands, name)), name


def test_moments_of_balls_between_rigid_rings():
    # rings that stand: the load of each ball depends on its own radius alone, F = ((t + 2 e) / (C_a + C_b))^1.5
    base = shipped("two-balls")
    ((support,), sigma, count) = base.supports, 1e-6, 150
    fixed = tuple((name, 0.0 if name == "ux" else value) for name, value in support.fixed)
    scene = replace(
        base,
        supports=(replace(support, fixed=fixed),),
        errors=replace(base.errors, balls=BallErrors(oversize=1e-6, sigma=sigma)),
        ingredients=replace(base.ingredients, hertz="error-free"),
    )
    found = run_members(scene, "lin", count)
    bare = member_of(without_draws(scene))
    ball, side = np.unravel_index(bare.load.argmax(), bare.load.shape)
    both = bare.hertz_C[ball, side] + bare.hertz_C[ball, 3 - side]
    start = both * bare.load[ball, side] ** (2.0 / 3.0)

    def moment(power):
        def weighted(e):
            return (max(start + 2.0 * e, 0.0) / both) ** (1.5 * power) * norm.pdf(e, scale=sigma)

        return integrate.quad(weighted, -8.0 * sigma, 8.0 * sigma, limit=200)[0]

    mean, deviation = moment(1), np.sqrt(moment(2) - moment(1) ** 2)
    assert abs(found.bands.mean[ball, side] - mean) < 4.0 * deviation / np.sqrt(count)
    assert found.bands.deviation[ball, side] == pytest.approx(deviation, rel=4.0 / np.sqrt(2.0 * count))
    assert mean != pytest.approx(bare.load[ball, side], rel=1e-3)


def test_random_errors_are_left_out_and_others_kept():
    side = SideErrors(profile=(1e-6,), profile_sigma=(1e-6,), pitch=(FourierTerm(1.0, sin=2e-6, sigma=1e-6),))
    bare = without_draws(with_errors(SL=side)).errors
    assert (bare.random, bare.SL.profile, bare.SL.pitch) == (False, (1e-6,), (FourierTerm(1.0, sin=2e-6),))


def test_life_of_equal_loads_goes_with_their_cube():
    load = np.zeros((8, 4))
    load[:, 0] = load[:, 3] = 100.0
    ratio = (life_sum(2.0 * load) / life_sum(load)) ** -0.9
    assert ratio == pytest.approx(1.0 / 8.0)
    assert life_sum(load * np.repeat([1.5, 0.5], 4)[:, None]) > life_sum(load)


def test_intervals_of_quantiles_cover():
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(300):
        quantile = statistics(rng.normal(size=200))["quantiles"][3]
        assert quantile["low"] <= quantile["value"] <= quantile["high"]
        hits += quantile["low"] <= norm.ppf(0.95) <= quantile["high"]
    assert hits >= binom.ppf(0.001, 300, 0.95)


@pytest.mark.parametrize("trials", [1, 7, 40])
@pytest.mark.parametrize("chance", [0.025, 0.5, 0.9])
def test_a_quantile_of_counts_is_the_least_that_has_the_probability(trials, chance):
    """Also at the probabilities of the counts themselves, where round-off decides."""
    share = bdtr(np.arange(trials + 1), trials, chance)
    for p in (*share[share < 1.0 - 1e-12], 0.025, 0.3, 0.975):
        assert _binomial_quantile(p, trials, chance) == np.flatnonzero(share >= p)[0]


def test_quantiles_of_a_binomial_variable_are_scipys():
    for trials, chance, p in product((2, 20, 99, 1000, 300_000), LEVELS, (0.025, 0.975)):
        assert _binomial_quantile(p, trials, chance) == binom.ppf(p, trials, chance)


def test_what_cannot_be_is_refused():
    loose = replace(RANDOM, supports=())
    for scene, model, count, words in (
        (shipped("lin-case1"), "lin", 5, "random"),
        (RANDOM, "x", 5, "x"),
        (RANDOM, "lin", 1, "2 to"),
        (loose, "lin", 3, "not held"),
    ):
        with pytest.raises(InputError, match=words):
            run_members(scene, model, count)


FEW = ("lin-random", "--members", "4", "--model", "lin")


def test_command(tmp_path, command):
    rows = tmp_path / "members.csv"
    code, data = command.json("solve", *FEW, "--seed", "7", "--csv", rows, "--json")
    assert code == 0
    assert (data["members"], data["converged"], data["seed"]) == (4, 4, 7)
    largest = data["statistics"]["largest_load_N"]
    assert largest["members"] == 4
    found = list(csv.DictReader(rows.read_text(encoding="utf-8").splitlines()))
    assert [row["member"] for row in found] == ["0", "1", "2", "3"]
    assert list(KEPT) == list(found[0])[2:]
    assert max(float(row["largest_load_N"]) for row in found) == largest["largest"]
    assert max(ball["largest_N"] for ball in data["balls"]) == largest["largest"]


def test_distributions_come_first_and_bands_where_asked_for(command):
    for options, words in (((), "bands of every ball: --balls"), (("--balls",), "bands of the contact loads / N")):
        _, out, _ = command("solve", *FEW, *options)
        assert 0 < out.index("largest contact") < out.index(words)
        assert ("\n   32    SL" in out) == bool(options)
