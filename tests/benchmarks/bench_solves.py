"""What solves, set-ups and samples cost: ``pytest -n 0 tests/benchmarks/bench_solves.py``.

The plain test run does not collect it. Linear algebra on one thread, kernels compiled before they are timed.
"""

from dataclasses import replace
from itertools import count

import pytest

from rollbench.compare.cases.lin.evidence.source_cases import screw_pair_with_inferred_oversize
from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.models.study import with_ball_count
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.friction_kinds.common import FrictionScene
from rollbench.compare.studies.members.ensemble import solve_random_draws
from rollbench.compare.studies.members.members import solve_random_draws_of_scene
from rollbench.compare.studies.rolling.cases import prepare_rolling_case
from rollbench.compare.studies.rolling.runs import LEVELS
from rollbench.compare.studies.sweep.keys import read_varied_keys
from rollbench.compare.studies.sweep.sample import solve_sample
from rollbench.hifi.rolling.balls import RollingSettings, solve_half_space_contact_under_1_N, solve_rolling
from rollbench.lowfi.as_source import solve_by_lin_equations
from rollbench.lowfi.friction.screw.run import solve_pair_of_screw_balls
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.random_errors.chain import solve_ensemble
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.contacts import clear_nominal_caches
from rollbench.lowfi.statics.response import clear_compliance_caches
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.axis import Housing, RollingSet, diagonal_stiffness
from rollbench.meshes.cache import without_geometry_cache
from rollbench.meshes.parts import Friction

CASE = catalogue.scene("lin-case1")
COMPILED = ModelOptions(engine="compiled", estimate_beam_mesh_error=False)


def test_solve_by_lin_geometry_unknown(benchmark):
    benchmark.pedantic(
        lambda: solve_static(CASE, engine="compiled"), setup=clear_nominal_caches, rounds=30, warmup_rounds=1
    )


def test_solve_by_lin(benchmark):
    benchmark(lambda: solve_static(CASE, engine="compiled"))


def test_solve_by_lin_interpreted(benchmark):
    benchmark(lambda: solve_static(CASE, engine="interpreted"))


def test_solve_by_the_source_s_newton(benchmark):
    benchmark(lambda: solve_by_lin_equations(CASE, tolerance=1e-10))


def test_solve_refined_bodies_kept(benchmark):
    benchmark(lambda: run_model(CASE, "refined", COMPILED))


def test_solve_refined_bodies_new(benchmark):
    run_model(CASE, "refined", COMPILED)
    with without_geometry_cache():
        benchmark.pedantic(lambda: run_model(CASE, "refined", COMPILED), setup=clear_compliance_caches, rounds=3)


@pytest.mark.parametrize(("model", "balls"), [("lin", 32), ("lin", 125), ("lin", 500), ("refined", 32), ("refined", 125)])
def test_growth_with_balls(benchmark, model, balls):
    scene = with_ball_count(CASE, balls)
    run_model(scene, model, COMPILED)
    benchmark.pedantic(lambda: run_model(scene, model, COMPILED), rounds=5)


@pytest.mark.parametrize("name", ["lin-random", "lin-case3-tolerances"])
def test_thousand_members_by_lin(benchmark, name):
    scene = catalogue.scene(name)
    solve_random_draws(scene, 10)
    benchmark.pedantic(lambda: solve_random_draws(scene, 1000), rounds=3)


def test_hundred_members_refined(benchmark):
    scene = catalogue.scene("lin-random")
    solve_random_draws_of_scene(scene, "refined", 10)
    benchmark.pedantic(lambda: solve_random_draws_of_scene(scene, "refined", 100), rounds=3)


def row_of_nuts(number):
    """Nuts of the shipped double nut, each in a housing on springs, along one shaft."""
    base = catalogue.shipped_scene("double-nut")
    first, pitch = base.sets[0], 0.06
    screw = replace(base.screw, length=pitch * (number + 1))
    sets, housings = [], []
    for i in range(number):
        z, name = pitch * (i + 1), f"housing {i}"
        own = replace(first.parts.screw, length=screw.length)
        parts = replace(first.parts, screw=own, nut=replace(first.parts.nut, position=z))
        sets.append(RollingSet(f"nut {i}", "ball nut", parts, z, name))
        housings.append(Housing(name, z, (), diagonal_stiffness((1e9, 1e9, 1e9, 1e6, 1e6, 1e6))))
    return replace(base, screw=screw, sets=tuple(sets), housings=tuple(housings))


def test_double_nut(benchmark):
    pair = catalogue.shipped_scene("double-nut")
    benchmark(lambda: solve_assembly(pair, engine="compiled"))


@pytest.mark.parametrize("number", [4, 16])
def test_nuts_on_one_shaft(benchmark, number):
    row = row_of_nuts(number)
    solve_assembly(row, engine="compiled")
    benchmark.pedantic(lambda: solve_assembly(row, engine="compiled"), rounds=3)


@pytest.mark.parametrize("varied", ["errors.balls.oversize=0 um:7 um", "nut.outer_diameter=46 mm:60 mm"])
def test_sample_of_a_sweep(benchmark, varied):
    text, (vary,), numbers = catalogue.shipped_scene_text("lin-pitch"), read_varied_keys([varied]), count(1)

    def sample():
        solve_sample(
            text,
            "lin-pitch.toml",
            [vary],
            [vary.value_at_relative_position((0.618 * next(numbers)) % 1.0)],
            "refined",
            "compiled",
        )

    sample()
    benchmark.pedantic(sample, rounds=10)


def test_friction_of_a_whole_screw(benchmark):
    result = run_model(CASE, "refined", COMPILED)
    friction = Friction(0.1, 0.1)
    friction_state(CASE, result, friction, ONE_TURN, 0)
    benchmark(lambda: friction_state(CASE, result, friction, ONE_TURN, 0))


def test_pair_of_balls_of_a_screw(benchmark):
    pair = screw_pair_with_inferred_oversize()
    benchmark(lambda: solve_pair_of_screw_balls(pair))


@pytest.mark.parametrize("name", ["lin-pair-a", "lin-screw-pair-a-inferred"])
def test_rolling_contact_in_3d(benchmark, name):
    whole = prepare_rolling_case(catalogue.shipped_scene_of_kind(name, FrictionScene), RollingSettings(LEVELS[1])).touching
    solve_rolling(whole, RollingSettings(LEVELS[1]))
    benchmark.pedantic(
        lambda: solve_rolling(whole, RollingSettings(LEVELS[1])),
        setup=solve_half_space_contact_under_1_N.cache_clear,
        rounds=3,
    )


def test_screws_with_random_errors(benchmark):
    chain = liu.calibrated_axial_model("constant")
    solve_ensemble(chain, 2e-6, [1000.0], 10)
    found = benchmark.pedantic(lambda: solve_ensemble(chain, 2e-6, [1000.0], 2000), rounds=3)
    assert not found.failed
