"""Random scenes on every step of the ladder: convergence, balance, one solution, a convex energy, mirror images."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL, mirrored, relative, small_screw
from tests.property.test_invariance import end_for_end
from tests.slow import all_slow_but
from tests.static_problems import elastic_equations

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.parts import LADDER, REFINED, fixed_surface
from rollbench.lowfi.statics.equilibrium import find_equilibrium, state_at
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.parts import BallErrors, Errors, Load, Support

pytestmark = pytest.mark.xdist_group("random scenes")

SEEDS = range(14)


@cache
def random_scene(seed):
    """Loads of 1 N to 50 kN, preload or clearance up to 10 um, a bent or tilted shaft, either hand, one or two starts."""
    rng = np.random.default_rng(seed)
    hand, starts = rng.choice(["right", "left"]), int(rng.choice([1, 1, 2]))
    lead = float(rng.choice([10e-3, 20e-3, 28e-3])) * starts
    turns = float(rng.uniform(1.0, 2.5))
    scene = small_screw(int(rng.integers(5, 15)), turns, lead=lead, hand=str(hand), phase=float(rng.uniform(0.0, 6.0)))
    length = turns * lead + float(rng.uniform(8e-3, 25e-3))
    size = 10.0 ** rng.uniform(0.0, np.log10(5e4))
    share = rng.uniform(-1.0, 1.0, 2) * rng.choice([0.0, 0.05, 0.4])
    force = (size * share[0], size * share[1], float(rng.choice([-1.0, 1.0])) * size)
    tilt = {"rx": float(rng.uniform(-1, 1) * 2e-4), "uy": float(rng.uniform(-1, 1) * 1e-5)} if seed % 3 == 0 else {}
    fixed = tuple((dict(ALL_BUT_AXIAL) | tilt).items())
    oversize = float(rng.uniform(-1e-5, 1e-5))
    return replace(
        scene,
        name=f"random {seed}",
        track=replace(scene.track, starts=starts),
        screw=replace(scene.screw, bore=float(rng.choice([0.0, 8e-3, 14e-3]))),
        nut=replace(scene.nut, length=length, outer_diameter=float(rng.uniform(45e-3, 60e-3))),
        solid=replace(scene.solid, nut_held=str(rng.choice(["left face", "right face", "both faces", "outer surface"]))),
        errors=Errors(balls=BallErrors(oversize=oversize, sigma=float(rng.choice([0.0, 5e-7]))), seed=seed),
        supports=(Support(0.0, fixed),),
        loads=(Load(0.1, force, (0.0, 2e-3 * size * share[1], 0.0)),),
    )


@cache
def solved(seed, backend):
    return solve_elastic(random_scene(seed), backend=LADDER[backend], name=backend)


@pytest.mark.parametrize("backend", LADDER)
@pytest.mark.parametrize("seed", all_slow_but(SEEDS[:4], SEEDS))
def test_random_scenes_balance(seed, backend):
    result = solved(seed, backend)
    assert result.status == "converged"
    assert result.solver.residual <= max(1e-10, result.solver.round_off_bound)
    assert result.equilibrium.force_residual < 1e-8
    assert result.equilibrium.moment_residual < 1e-8
    assert not any("negative compliance" in text for text in result.left_out)
    assert (result.load > 0.0).any()


@pytest.mark.parametrize("backend", LADDER)
@pytest.mark.parametrize("seed", all_slow_but(SEEDS[:4], SEEDS[::3]))
def test_any_start_leads_to_the_same_loads(seed, backend):
    elastic = elastic_equations(random_scene(seed), LADDER[backend])
    assert solve_alone(elastic.solve_by_newton()).residual <= 1e-10
    state, scale, rng = elastic.state, elastic.residual_force_scale, np.random.default_rng(seed)
    for size in (0.1, 10.0):
        phi = state.phi + size * scale * rng.normal(size=state.phi.shape)
        found, outcome = find_equilibrium(elastic.system, (phi, state.a + rng.normal(0.0, 1e-5 * size, state.a.shape)))
        assert outcome.residual[0] <= 1e-10
        assert np.abs(found.forces.contacts.force - state.forces.contacts.force).max() < 1e-8 * scale


def energy_at(elastic, phi, amplitudes):
    """Energy of bodies, loads and balls, and its slopes by forces and free motions."""
    bodies, state = elastic.system.bodies, state_at(elastic.system, phi, amplitudes)
    f = state.forces.on_flanks
    return state.energy[0], bodies.motions_by_forces(phi - f), -bodies.free.work - bodies.free.loads(f)


@pytest.mark.parametrize("backend", LADDER)
@pytest.mark.parametrize("seed", all_slow_but(SEEDS[:4], SEEDS[1::3]))
def test_chords_lie_above_the_energy(seed, backend):
    """Midpoint convexity and the tangent below, along segments from small to far beyond the solution's own forces."""
    elastic = elastic_equations(random_scene(seed), LADDER[backend])
    assert solve_alone(elastic.solve_by_newton()).residual <= 1e-10
    phi, amplitudes, scale = elastic.state.phi.copy(), elastic.state.a.copy(), elastic.residual_force_scale
    rng = np.random.default_rng(seed)
    lowest = energy_at(elastic, phi, amplitudes)[0]
    for size in (1e-2, 0.3, 5.0):
        steps = [(rng.normal(size=phi.shape), rng.normal(size=amplitudes.shape)) for _ in range(2)]
        ends = [(phi + size * scale * f, amplitudes + 1e-5 * size * a) for f, a in steps]
        (low, slope, by_motions), (high, _, _) = (energy_at(elastic, *end) for end in ends)
        middle, _, _ = energy_at(elastic, *(0.5 * (a + b) for a, b in zip(*ends, strict=True)))
        rounding = 1e-11 * (abs(low) + abs(high))
        assert lowest <= min(low, high, middle) + rounding
        assert middle <= 0.5 * (low + high) + rounding
        ahead = float((slope * (ends[1][0] - ends[0][0])).sum() + (by_motions * (ends[1][1] - ends[0][1])).sum())
        assert high >= low + ahead - rounding


@pytest.mark.parametrize("backend", LADDER)
@pytest.mark.parametrize("seed", all_slow_but(SEEDS[:4], SEEDS[2::3]))
def test_mirror_image(seed, backend):
    scene = random_scene(seed)
    one, other = solved(seed, backend), solve_elastic(mirrored(scene), backend=LADDER[backend])
    assert relative(other.load, one.load) < 1e-8
    assert relative(other.centreline, one.centreline * [1, -1, 1, -1, 1, -1]) < 1e-8


@pytest.mark.parametrize("backend", LADDER)
@pytest.mark.parametrize("nut_held", all_slow_but(["left face"], ["left face", "both faces"]))
def test_turned_end_for_end(nut_held, backend):
    """Bodies, contacts and clamped faces exchange their ends; the shaft's kernel sends its forces to one end always."""
    scene = small_screw(12, 2.0, phase=0.3, oversize=3e-6, force=(150.0, -80.0, 2500.0), moment=(2.0, 3.0, 0.0))
    both = (scene, nut_held), (end_for_end(scene), nut_held.replace("left", "right"))
    scenes = (replace(s, solid=replace(s.solid, nut_held=name)) for s, name in both)
    one, other = (solve_elastic(s, backend=LADDER[backend]) for s in scenes)
    apart = relative(other.load[::-1, [1, 0, 3, 2]], one.load)
    assert apart < (1e-10 if LADDER[backend].screw == "beam" else 4e-3)


@pytest.mark.parametrize("name", ["bearing-9", "bearing-9-preload"])
def test_elastic_rings(name):
    """Bearings without lead: rings held outside and by the bore answer by kernels; loads near those of rigid rings."""
    scene = catalogue.scene(name)
    assert [fixed_surface(scene, screw) for screw in (True, False)] == ["bore", "outer"]
    lin = solve_elastic(scene, backend=LADDER["lin"])
    found = solve_elastic(scene, backend=REFINED)
    assert found.status == lin.status == "converged"
    assert found.equilibrium.force_residual < 1e-9
    assert 1e-3 < relative(found.load, lin.load) < 0.05  # stiffer flanks and softer, oblique contacts nearly cancel
    assert np.abs(found.load.sum(axis=0) / lin.load.sum(axis=0) - 1.0).max() < 0.2


def test_stretch_of_shaft_beyond_the_nut_does_not_matter():
    scene = catalogue.scene("lin-case3-offset")
    one, other = (solve_elastic(replace(scene, solid=replace(scene.solid, shaft=x))).load for x in (25e-3, 60e-3))
    assert np.abs(other - one).max() < 5e-4 * one[one > 0.0].mean()
