"""BSCB-1 in the report: every program that has solved its problems, scored: levels of the 3D reference, low-order models,
and what wings know of other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollbench.comparison.models.registry import DEFAULT, MODELS, Options, run_model
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import Run, bodies_path, shipped_store
from rollbench.comparison.registration import offered
from rollbench.comparison.wings.benchmark.answers import Answers, mean_load, shipped
from rollbench.comparison.wings.benchmark.problems import NAME, PROBLEMS, RUNS, Problem, reference_of
from rollbench.comparison.wings.benchmark.scoring import LOAD, Given, Score, score
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Quantity, Row, Section, Table, Text

ABOUT = (
    f"{NAME} consists of twelve contact problems, from two balls to 136, in which everything that the answer "
    "depends on is fixed. rollbench benchmark export DIR writes them with the answers and a page that "
    "explains them; rollbench benchmark score FILE.csv judges the loads of any program. A level of the 3D "
    "reference that provides the answer to a problem is not scored on it. No other program has published "
    "loads for these problems; CalculiX was run on two of them here."
)


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
    def of(self) -> str:
        """The same in words."""
        return f"{self.passed} of {len(self.scores)}"

    @property
    def worst(self) -> float:
        """Largest error of any load [% of the mean load]."""
        return max(abs(s.worst_percent) for s in self.scores.values())


def programs(study: Study, step: Callable[[str], None]) -> list[Program]:
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


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    found = programs(study, step)
    items = Text((ABOUT,)), program_table(found), problem_table()
    return Section("benchmark", f"The benchmark {NAME}", items, conclusion=conclusion(found))


def conclusion(found: Sequence[Program]) -> str:
    """Who passes and who does not, in two sentences."""
    whole = [p for p in found if p.passed == len(p.scores)]
    beyond = [p for p in found if p.passed < len(p.scores)]
    refined = next(p for p in found if p.name == MODELS[DEFAULT].label)
    failed = ", ".join(name for name, s in refined.scores.items() if not s.passed) or "none"
    names = ", ".join(f"{p.name} ({p.of})" for p in whole) or "no program"
    best = max((p.passed / len(p.scores) for p in beyond), default=0.0)
    return (
        f"Within the uncertainty of the answers plus {LOAD:g} % of the mean load on every problem they "
        f"solve: {names}. The refined model passes {refined.of} (not: {failed}); its worst load is wrong "
        f"by {refined.worst:.2f} % of the mean load. Of the programs that fail somewhere, the best passes "
        f"{100.0 * best:.0f} % of its problems."
    )


def program_table(found: Sequence[Program]) -> Table:
    """Largest error of a load by program and problem."""
    rows: list[Row] = []
    for p in found:
        row: Row = {"program": p.name, Quantity("passed", "passed", "", "s"): p.of}
        for name in PROBLEMS:
            column = Quantity(name, name, "% of mean", ".2f")
            row[column] = abs(p.scores[name].worst_percent) if name in p.scores else None
        rows.append(row)
    return Table.of("benchmark", f"{NAME}: largest error of a contact load, by program and problem", rows)


def problem_table() -> Table:
    """The problems, with the uncertainty of their answers."""
    rows: list[Row] = []
    for name, answers in shipped().items():
        mean, loaded = mean_load(answers), [c for c in answers.values() if c.load > 0.0]
        rows.append(
            {
                "problem": name,
                "shows": PROBLEMS[name].shows,
                Quantity("contacts", "loaded contacts", "", "s"): str(len(loaded)),
                Quantity("mean", "mean load", "N", ".1f"): mean,
                Quantity("uncertainty", "largest uncertainty", "% of mean", ".2f"): (
                    100.0 * max(c.uncertainty for c in loaded) / mean
                ),
            }
        )
    return Table.of("benchmark-problems", f"The problems of {NAME}", rows)
