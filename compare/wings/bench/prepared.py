"""Models ready to be timed: set up on a scene, with the state that each run begins from."""

from __future__ import annotations

from functools import partial

import numpy as np

from rollbench.lowfi.as_source import static as lin
from rollbench.lowfi.statics.elastic import ElasticBuild
from rollbench.lowfi.statics.kernel_types import Outcome
from rollbench.lowfi.statics.problem import Problem, build, distances
from rollbench.lowfi.statics.selection import choose_sides
from rollbench.lowfi.statics.static import Beam, pick_engine, prepare
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene

#: Relative residual that both formulations solve to.
TOLERANCE = 1e-10
WARM_LOAD = 1.01


class Energy:
    """The energy solver on one scene, compiled, with the start that each run begins from."""

    def __init__(self, scene: Scene, *, everything: bool = False, tolerance: float = TOLERANCE) -> None:
        """Build the system; ``everything``: all four sides."""
        layout = ball_layout(scene)
        drawn = specimen(scene, layout)
        known = distances(scene, drawn)
        use = np.ones(4, dtype=bool) if everything else choose_sides(scene, drawn, known)
        problem = build(scene, drawn, layout, use, known=known)
        self.packed = partial(prepare, problem, pick_engine("compiled", scene.ball_count), tolerance=tolerance)
        self.prepared: Beam = self.packed()
        self.begin = [a.copy() for a in self.prepared.state]
        self.unknowns = problem.unknowns
        self.iterations = 0

    def reset(self) -> None:
        """The state that the next run begins from."""
        for a, b in zip(self.prepared.state, self.begin, strict=True):
            a[...] = b

    def cold(self) -> None:
        """From the nominal state: linear start, then Newton."""
        self._check(self.prepared.iterate())

    def warm(self) -> None:
        """From the present state."""
        self._check(self.prepared.iterate(False))

    def change_load(self) -> None:
        """Make the solution the start of the next runs, and change the load by 1 %."""
        self.reset()
        self.cold()
        self.begin = [a.copy() for a in self.prepared.state]
        self.prepared.given.shaft.load[...] *= WARM_LOAD

    def _check(self, outcome: Outcome) -> None:
        self.iterations = outcome.iterations
        if not (outcome.status <= 1 and outcome.residual <= 1e-10):
            raise RuntimeError(f"bench: our solver stopped with residual {outcome.residual:.1e}")


class Source:
    """The source's Newton (kinematics of Lin 2.18-2.21) on one scene, set up, with its designer's guess."""

    def __init__(self, scene: Scene, member: int = 0, tolerance: float = TOLERANCE) -> None:
        """Build the system: all four sides of every ball, as its equations have them."""
        layout = ball_layout(scene)
        self.problem: Problem = build(scene, specimen(scene, layout, member), layout, np.ones(4, dtype=bool))
        axes = np.stack([layout.radial, layout.binormal], axis=1)
        inner = 6 * layout.z.size
        free = np.concatenate([np.arange(inner), inner + np.flatnonzero(~self.problem.fixed.ravel())])
        self.system = lin.System(self.problem, "source", lin.beam_matrix(self.problem), free, axes)
        self.load = self.problem.load.ravel()
        self.unknowns = free.size
        self.begin = lin.initial_state(self.system, "guess", 1.0)
        self.tolerance = tolerance
        self.status = ""

    def solve(self) -> Array:
        """Newton from the present start; the solution."""
        x, _, _, self.status = lin.newton(self.system, self.begin, self.load, self.tolerance)
        return x

    def solve_by_steps(self) -> Array:
        """Newton by ten load steps, the first from the guess for a tenth of the load; the solution."""
        x = lin.initial_state(self.system, "load steps", 0.1)
        for fraction in np.linspace(0.1, 1.0, 10):
            x, _, _, self.status = lin.newton(self.system, x, float(fraction) * self.load, self.tolerance)
            if self.status != "converged":
                break
        return x

    def change_load(self) -> None:
        """Make the solution the start of the next runs, and change the load by 1 %."""
        self.begin = self.solve()
        self.load = WARM_LOAD * self.load


class Refined:
    """The refined model on one scene, compiled; the state that each run begins from is its linear start."""

    def __init__(self, scene: Scene, *, everything: bool = False) -> None:
        """Build the bodies and the system; ``everything``: all four sides."""
        layout = ball_layout(scene)
        drawn = specimen(scene, layout)
        use = np.ones(4, dtype=bool) if everything else choose_sides(scene, drawn)
        kernels = pick_engine("compiled", scene.ball_count)
        build = ElasticBuild(scene, drawn, layout, use, kernels, everything)
        self.elastic = build.ready(build.problem())
        self.unknowns = self.elastic.state.phi.size + self.elastic.state.a.size
        self.iterations = 0

    def cold(self) -> None:
        """Linear start, then Newton on the contact forces."""
        outcome = self.elastic.iterate()
        self.iterations = outcome.iterations
        if not (outcome.status <= 1 and outcome.residual <= 1e-10):
            raise RuntimeError(f"bench: the refined model stopped with residual {outcome.residual:.1e}")
