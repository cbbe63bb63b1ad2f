"""Run times of the 3D model of rolling: steady pairs, a further load case, a run from rest; how time grows with cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from joblib.externals.loky import get_reusable_executor

from rollbench.compare.scenes.catalogue import case as shipped_case
from rollbench.compare.scenes.kinds import KindScene
from rollbench.compare.system import cores
from rollbench.compare.wings.bench.costs.timing import Job, timed
from rollbench.compare.wings.rolling.cases import case_of
from rollbench.compare.wings.rolling.changes import DURATION, GAP
from rollbench.compare.wings.rolling.low_order import low_order
from rollbench.compare.wings.rolling.runs import LEVELS
from rollbench.hifi.rolling.balls import Choices, finite_patch, prepare_bodies, solve_rolling, unit_patch
from rollbench.hifi.rolling.bodies import Sizes, forget_kernels
from rollbench.hifi.rolling.kinematics import Rolling
from rollbench.hifi.rolling.transient import run_from_rest
from rollbench.meshes.memory import peak_MB

#: Grids of the steady scenes, of the run from rest, and a coarse one; targets [s].
PRODUCTION, REST, COARSE = LEVELS[1], (12, 16), (10, 12)
TARGETS = {"lin-pair-a": 5.0, "lin-screw-pair-a-inferred": 15.0}
AGAIN, STEPS, STEPS_TARGET = 1.0, 50, 30.0


def jobs(repeats: int = 3) -> Iterator[Job]:
    """Steady pairs with all set-up, a further load case, steps from rest; one core but for the set-up of finite bodies."""
    for name, target in TARGETS.items():
        yield _steady(name, target, repeats)
        yield _finite(name, target)
    linear = _scene("lin-pair-a", PRODUCTION)
    first = solve_rolling(linear, Choices(PRODUCTION))
    heavier = _heavier(linear)
    again = timed(lambda: solve_rolling(heavier, Choices(PRODUCTION), first), repeats)
    yield Job("rolling: further load case", again, None, _unknowns(linear, PRODUCTION), peak_MB(), _aim(AGAIN))
    rest = timed(lambda: run_from_rest(linear, DURATION, STEPS, GAP, Choices(REST)), 1)
    note = f"{REST[0]} x {REST[1]} cells; {_aim(STEPS_TARGET)}"
    yield Job(f"rolling: {STEPS} steps from rest", rest, None, _unknowns(linear, REST), peak_MB(), note)


def _steady(name: str, target: float, repeats: int) -> Job:
    scene = shipped_case(name, KindScene)
    whole = _scene(name, PRODUCTION)

    def solve(shape: tuple[int, int]) -> None:
        unit_patch.cache_clear()
        solve_rolling(whole, Choices(shape))

    fine, coarse = timed(lambda: solve(PRODUCTION), repeats), timed(lambda: solve(COARSE), repeats)
    cells = _unknowns(whole, PRODUCTION) / _unknowns(whole, COARSE)
    exponent = float(np.log(fine / coarse) / np.log(cells))
    _, low, _ = low_order(scene)
    note = f"{PRODUCTION[0]} x {PRODUCTION[1]} cells, set-up included; time as unknowns to the power {exponent:.1f}; "
    note += f"{fine / low:.3g} times the low-order model's; {_aim(target)}"
    return Job(f"rolling: {name}, steady", fine, None, _unknowns(whole, PRODUCTION), peak_MB(), note)


def _finite(name: str, target: float) -> Job:
    """The first solve on finite bodies: meshes and their answers once for all scenes of a geometry, on all cores."""
    whole, processes = _scene(name, PRODUCTION), cores()

    def solve() -> None:
        prepare_bodies((whole,), Sizes(), processes)
        solve_rolling(whole, Choices(PRODUCTION, bodies=Sizes()))

    seconds = timed(solve, 1, _forget)
    cells = f"{PRODUCTION[0]} x {PRODUCTION[1]} cells"
    note = f"{cells}, meshes of the bodies and start of {processes} processes included; {_aim(target)}"
    return Job(f"rolling: {name}, steady, finite bodies", seconds, None, _unknowns(whole, PRODUCTION), peak_MB(), note)


def _forget() -> None:
    get_reusable_executor().shutdown(wait=True)
    forget_kernels()
    finite_patch.cache_clear()


def _aim(seconds: float) -> str:
    return f"target {seconds:g} s"


def _scene(name: str, shape: tuple[int, int]) -> Rolling:
    scene = shipped_case(name, KindScene)
    return case_of(scene, Choices(shape)).touching


def _unknowns(scene: Rolling, shape: tuple[int, int]) -> int:
    """Tangential forces of all cells of all loaded contacts."""
    loaded = [t for b in scene.balls for t in b.touches if t.load > 0.0]
    return sum(2 * len(unit_patch(t.radii, scene.young, scene.poisson, shape).at) for t in loaded)


def _heavier(scene: Rolling) -> Rolling:
    """Every load one per cent larger on the first ball."""
    first, *others = scene.balls
    first = replace(first, touches=tuple(replace(t, load=1.01 * t.load) for t in first.touches))
    return replace(scene, balls=(first, *others))
