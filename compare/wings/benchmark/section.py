"""BSCB-1 in the report: every program that has solved its problems, scored."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.comparison.models.registry import DEFAULT, MODELS
from rollbench.comparison.models.study import Study
from rollbench.comparison.wings.benchmark.answers import mean_load, shipped
from rollbench.comparison.wings.benchmark.problems import NAME, PROBLEMS
from rollbench.comparison.wings.benchmark.programs import Program, programs
from rollbench.comparison.wings.benchmark.scoring import LOAD
from rollbench.reports.records import Quantity, Row, Section, Table, Text

ABOUT = (
    f"{NAME} consists of twelve contact problems, from two balls to 136, in which everything that the answer "
    "depends on is fixed. rollbench benchmark export DIR writes them with the answers and a page that "
    "explains them; rollbench benchmark score FILE.csv judges the loads of any program. A level of the 3D "
    "reference that provides the answer to a problem is not scored on it. No other program has published "
    "loads for these problems; CalculiX was run on two of them here."
)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    found = programs(study, step)
    items = Text((ABOUT,)), program_table(found), problem_table()
    return Section("benchmark", f"The benchmark {NAME}", items, conclusion=conclusion(found))


def _by_label(found: Sequence[Program]) -> dict[str, Program]:
    return {p.name: p for p in found}


def _of(program: Program) -> str:
    return f"{program.passed} of {len(program.scores)}"


def conclusion(found: Sequence[Program]) -> str:
    """Who passes and who does not, in two sentences."""
    whole = [p for p in found if p.passed == len(p.scores)]
    beyond = [p for p in found if p.passed < len(p.scores)]
    refined = _by_label(found)[MODELS[DEFAULT].label]
    failed = ", ".join(name for name, s in refined.scores.items() if not s.passed) or "none"
    names = ", ".join(f"{p.name} ({_of(p)})" for p in whole) or "no program"
    best = max((p.passed / len(p.scores) for p in beyond), default=0.0)
    return (
        f"Within the uncertainty of the answers plus {LOAD:g} % of the mean load on every problem they "
        f"solve: {names}. The refined model passes {_of(refined)} (not: {failed}); its worst load is wrong "
        f"by {refined.worst:.2f} % of the mean load. Of the programs that fail somewhere, the best passes "
        f"{100.0 * best:.0f} % of its problems."
    )


def program_table(found: Sequence[Program]) -> Table:
    """Largest error of a load by program and problem."""
    rows: list[Row] = []
    for p in found:
        row: Row = {"program": p.name, Quantity("passed", "passed", "", "s"): _of(p)}
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
