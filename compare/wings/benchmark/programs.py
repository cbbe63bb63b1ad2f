"""Every program that has solved problems of the benchmark, scored: levels of the 3D reference, low-order models, and what
wings know of other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollbench.comparison.models.registry import MODELS, Options, run_model
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import Run, bodies_path, shipped_store
from rollbench.comparison.registration import offered
from rollbench.comparison.wings.benchmark.answers import Answers, shipped
from rollbench.comparison.wings.benchmark.problems import PROBLEMS, RUNS, Problem, reference_of
from rollbench.comparison.wings.benchmark.scoring import Given, Score, score
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

#: Model whose bodies come from a file; of them those of the finest run.
CONDENSED = "condensed"


@dataclass(frozen=True)
class Program:
    """A program and its scores by problem; problems that it has not solved are absent."""

    name: str
    scores: dict[str, Score]

    @property
    def passed(self) -> int:
        """Problems within their tolerances."""
        return sum(s.passed for s in self.scores.values())

    @property
    def worst(self) -> float:
        """Largest error of any load [% of the mean load]."""
        return max(abs(s.worst_percent) for s in self.scores.values())


def programs(study: Study, step: Callable[[str], None] = lambda _: None) -> list[Program]:
    """All programs that have solved a problem, the finest first."""
    answers = shipped()
    out: dict[str, dict[str, Score]] = {}
    for name, one in PROBLEMS.items():
        step(f"{name}: models")
        for program, found in _loads(one, study):
            out.setdefault(program, {})[name] = score(name, answers[name], _given(found, answers[name]))
    order = [f"3D reference, level {k}" for k in range(9, 0, -1)]
    ranked = sorted(out, key=lambda p: order.index(p) if p in order else len(order))
    return [Program(p, out[p]) for p in ranked]


def _given(load: Array, answers: Answers) -> dict[str, Given]:
    """Loads ``(n, 4)`` [N] as a file would hold them."""
    return dict(zip(answers, (Given(float(x), {}) for x in load.ravel()), strict=True))


def _loads(one: Problem, study: Study) -> Iterator[tuple[str, Array]]:
    """Loads ``(n, 4)`` [N] of a problem by program; the finest run of the reference is the answer and not there."""
    scene, found = one.described, reference_of(one)
    for k, run in list(enumerate(found[0].found.runs))[:-1]:
        yield f"3D reference, level {run.level}", np.concatenate([referenced.found.runs[k].load for referenced in found])
    for add in offered("other program"):
        name, loads = add()
        if one.scene in loads:
            yield name, loads[one.scene]
    for name, model in MODELS.items():
        if isinstance(scene, Assembly):
            if callable(model.assembly):
                yield model.label, np.concatenate([balls.load for balls in run_model(scene, name).of_balls()])
            continue
        if not model.suits(scene):
            continue
        if name != CONDENSED:
            result = study.solve(scene, name)
        elif path := _bodies(scene, found[0].found.best):
            result = run_model(scene, name, Options(condensed=path))
        else:
            continue
        if result.converged:
            yield model.label, result.load


def _bodies(scene: Scene, run: Run) -> Path | None:
    """File of the condensed bodies of a run, where one is stored."""
    return next((p for store in (RUNS, shipped_store()) if (p := bodies_path(store, scene, run)).exists()), None)
