"""The command ``rollbench benchmark``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.comparison.commands.printing import Answer, on_terminal
from rollbench.comparison.commands.tables import ruled
from rollbench.comparison.errors import InputError
from rollbench.comparison.reference.jobs import Engine, ensure, plan
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.wings.benchmark import answers, scoring
from rollbench.comparison.wings.benchmark.exporting import export
from rollbench.comparison.wings.benchmark.problems import HERE, NAME, PROBLEMS, RUNS, problem
from rollbench.comparison.wings.benchmark.scoring import LOAD, Score, named, read, score

#: Levels of its runs.
LEVELS = (1, 2, 4)
#: Size of a folder is said in this [bytes].
MB = 1e6


def run_benchmark(
    action: str, path: Path | None, *, problem: str, meshes: bool, step_files: bool, engine: Engine
) -> Answer:
    """One of the three actions. Raises InputError for a bad path or problem, and where a file cannot be written."""
    if action == "compute":
        return compute(path or HERE, engine)
    if path is None:
        wanted = "a folder to write to" if action == "export" else "a CSV file"
        raise InputError("command line", "path", "nothing", wanted, f"rollbench benchmark {action} PATH")
    if action == "export":
        return run_export(path, meshes=meshes, step_files=step_files)
    return run_score(path, problem)


def run_export(folder: Path, *, meshes: bool, step_files: bool) -> Answer:
    """Write the benchmark into a folder. Raises InputError."""
    if folder.exists() and not folder.is_dir():
        raise InputError(str(folder), "folder", "a file", "a folder to write to", "choose another name")
    files = export(folder, meshes=meshes, step_files=step_files, step=on_terminal)
    size = sum((folder / name).stat().st_size for name in files) / MB
    words = f"wrote {folder}: {len(files)} files, {size:.1f} MB; begin with {folder / 'README.html'}"
    return Answer({"folder": str(folder), "files": files, "size_MB": size}, [words])


def run_score(path: Path, only: str = "") -> Answer:
    """Score a file; only: one problem. Raises InputError for an unknown problem and a file that cannot be read."""
    names = [problem(only).name] if only else list(PROBLEMS)
    known = answers.shipped()
    given = read(path, known, only)
    scores = [score(name, known[name], given.get(name, {})) for name in names]
    passed = all(s.passed for s in scores)
    count = sum(s.passed for s in scores)
    verdict = f"{NAME}: {'passed' if passed else 'NOT passed'}, {count} of {len(scores)} problems within their tolerances"
    data = {"benchmark": NAME, "passed": passed, "problems": [s.as_json() for s in scores]}
    return Answer(data, [_table(scores), *_words(scores), verdict], 0 if passed else 1)


def _words(scores: Sequence[Score]) -> list[str]:
    """What is missing or beyond its tolerance, problem by problem."""
    out = []
    for s in scores:
        if s.missing:
            out.append(f"{s.problem}: missing: {named(s.missing)}")
        if s.misses:
            out.append(f"{s.problem}: beyond tolerance: {'; '.join(m.text for m in s.misses[: scoring.NAMED])}")
            if (rest := len(s.misses) - scoring.NAMED) > 0:
                out[-1] += f"; and {rest} more"
    return out


def _table(scores: Sequence[Score]) -> Any:
    rows = []
    for s in scores:
        worst = f"{s.worst_percent:+.2f}" if s.worst else "–"
        counts = (str(s.contacts), str(len(s.missing)), str(len(s.misses)))
        rows.append((s.problem, *counts, worst, s.worst, "passed" if s.passed else "NOT passed"))
    heads = ("problem", "contacts", "missing", "beyond", "worst load\n% of mean", "at", "verdict")
    title = f"{NAME}: loads within their uncertainty + {LOAD:g} % of the mean load"
    return ruled(title, heads, rows, ("problem", "at", "verdict"))


def compute(folder: Path, engine: Engine) -> Answer:
    """Compute the runs that no store holds and write the answers. Raises InputError where a run does not settle."""
    stores = (RUNS, shipped_store())
    failed = ensure(plan([p.described for p in PROBLEMS.values()], LEVELS), RUNS, engine, on_terminal, stores)
    if failed:
        raise InputError(NAME, failed[0].scene, failed[0].status, "a run that settles", "see the scene's loads")
    return Answer({"files": [str(p) for p in answers.save(folder)]}, [f"wrote {folder / answers.FILE}"])
