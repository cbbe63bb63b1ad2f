"""What solves, set-ups and samples cost: ``pytest -n 0 tests/benchmarks/bench_solves.py``.

The plain test run does not collect it. Linear algebra on one thread.
"""

from dataclasses import replace
from itertools import count

import pytest

from rollbench.compare.cases.lin.evidence.source_cases import oversized_pair
from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import with_ball_count
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.members.ensemble import solve_random_draws
from rollbench.compare.studies.members.members import solve_random_draws_of_scene
from rollbench.compare.studies.rolling.cases import prepare_rolling_case
from rollbench.compare.studies.rolling.runs import LEVELS
from rollbench.compare.studies.sweep.keys import read_varied_keys
from rollbench.compare.studies.sweep.sample import VariedScene, solve_samples
from rollbench.hifi.rolling.balls import RollingSettings, solve_half_space_contact_under_1_N, solve_rolling
from rollbench.lowfi.as_source.liu.ensemble import solve_ensemble
from rollbench.lowfi.as_source.newton import solve_by_lin_equations
from rollbench.lowfi.friction.screw.run import solve_pair_of_screw_balls
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.contacts import clear_nominal_caches
from rollbench.lowfi.statics.response import clear_compliance_caches
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.axis import Housing, RollingSet, diagonal_stiffness
from rollbench.meshes.cache import without_geometry_cache
from rollbench.meshes.parts import Friction

CASE, PAIR = catalogue.scene("lin-case1"), catalogue.shipped_scene("double-nut")
SCREW_PAIR, RANDOM = oversized_pair(), catalogue.scene("lin-random")
WITHOUT_MESH_ERROR = ModelOptions(estimate_beam_mesh_error=False)
SOLVES = {
    "lin": lambda: solve_static(CASE),
    "the source's Newton": lambda: solve_by_lin_equations(CASE, tolerance=1e-10),
    "refined, bodies kept": lambda: run_model(CASE, "refined", WITHOUT_MESH_ERROR),
    "double nut": lambda: solve_assembly(PAIR),
    "pair of balls of a screw": lambda: solve_pair_of_screw_balls(SCREW_PAIR),
    "thousand members": lambda: solve_random_draws(RANDOM, 1000),
    "thousand members with tolerances": lambda: solve_random_draws(catalogue.scene("lin-case3-tolerances"), 1000),
    "hundred members, refined": lambda: solve_random_draws_of_scene(RANDOM, "refined", 100),
}


def timed(benchmark, work, setup=None):
    """Time a work that was done once, so that caches are filled; setup: what is done before each round."""
    work()
    return benchmark.pedantic(work, setup=setup, rounds=5)


@pytest.mark.parametrize("name", SOLVES)
def test_solve(benchmark, name):
    benchmark(SOLVES[name])


def test_solve_by_lin_geometry_unknown(benchmark):
    timed(benchmark, SOLVES["lin"], clear_nominal_caches)


def test_solve_refined_bodies_new(benchmark):
    with without_geometry_cache():
        timed(benchmark, SOLVES["refined, bodies kept"], clear_compliance_caches)


@pytest.mark.parametrize(("model", "balls"), [("lin", 32), ("lin", 125), ("lin", 500), ("refined", 32), ("refined", 125)])
def test_growth_with_balls(benchmark, model, balls):
    scene = with_ball_count(CASE, balls)
    timed(benchmark, lambda: run_model(scene, model, WITHOUT_MESH_ERROR))


def row_of_nuts(number):
    """Nuts of the shipped double nut, each in a housing on springs, along one shaft."""
    first, places = PAIR.sets[0].parts, [0.06 * (i + 1) for i in range(number)]
    screw, springs = replace(PAIR.screw, length=0.06 * (number + 1)), diagonal_stiffness((1e9, 1e9, 1e9, 1e6, 1e6, 1e6))
    own = replace(first.screw, length=screw.length)
    parts = [replace(first, screw=own, nut=replace(first.nut, position=z)) for z in places]
    sets = [RollingSet(f"nut {z:g}", "ball nut", one, z, f"housing {z:g}") for z, one in zip(places, parts, strict=True)]
    housings = [Housing(f"housing {z:g}", z, (), springs) for z in places]
    return replace(PAIR, screw=screw, sets=tuple(sets), housings=tuple(housings))


@pytest.mark.parametrize("number", [4, 16])
def test_nuts_on_one_shaft(benchmark, number):
    row = row_of_nuts(number)
    timed(benchmark, lambda: solve_assembly(row))


@pytest.mark.parametrize("varied", ["errors.balls.oversize=0 um:7 um", "nut.outer_diameter=46 mm:60 mm"])
def test_sample_of_a_sweep(benchmark, varied):
    text, (vary,), numbers = catalogue.shipped_scene_text("lin-pitch"), read_varied_keys([varied]), count(1)

    def sample():
        value = vary.value_at_relative_position((0.618 * next(numbers)) % 1.0)
        solve_samples(VariedScene(text, "lin-pitch.toml", (vary,)), [[value]], "refined")

    timed(benchmark, sample)


def test_friction_of_a_whole_screw(benchmark):
    result = run_model(CASE, "refined", WITHOUT_MESH_ERROR)
    timed(benchmark, lambda: friction_state(CASE, result, Friction(0.1, 0.1), ONE_TURN, 0))


@pytest.mark.parametrize("name", ["lin-pair-a", "lin-screw-pair-a-inferred"])
def test_rolling_contact_in_3d(benchmark, name):
    settings = RollingSettings(LEVELS[1])
    whole = prepare_rolling_case(catalogue.shipped_scene_of_kind(name, FrictionScene), settings).touching
    timed(benchmark, lambda: solve_rolling(whole, settings), solve_half_space_contact_under_1_N.cache_clear)


def test_screws_with_random_errors(benchmark):
    chain = liu.calibrated_model("constant")
    assert not timed(benchmark, lambda: solve_ensemble(chain, 2e-6, [1000.0], 2000)).failed
