"""Sections of a report made in two processes side by side: those on models beside 3D, ways of holding a nut and
verification, and all others.

The two share no result that takes long: the first rest on the ladder, the points of error against run time and on rolling
contacts, the others on the evidence of printed tables. What measures times is made after both, by one process alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from time import perf_counter
from typing import Any

from rollbench.comparison.models.study import Study
from rollbench.comparison.registration import Part
from rollbench.comparison.system import cores
from rollbench.meshes.workers import local
from rollbench.reports.records import Section

Step = Callable[[str], None]


@dataclass(frozen=True)
class Made:
    """Sections by name, and the study that made them, without its results."""

    sections: dict[str, Section]
    study: Study


def split(wanted: Sequence[Part], study: Study) -> tuple[list[Part], list[Part]]:
    """Parts for a second process, and those for this one: all of them where the models are timed, this machine has one
    core, or there is nothing to make beside."""
    aside = [part for part in wanted if part.beside]
    if study.timed or cores() < 2 or all(part.beside or part.alone for part in wanted):
        aside = []
    return aside, [part for part in wanted if part not in aside]


def build(
    aside: Sequence[Part], others: Sequence[Part], announce: Step, step: Step, study: Study, then: Callable[[Study], None]
) -> dict[str, Section]:
    """All sections by name, those ``aside`` made by a second process.

    announce: told the name of each section of this process, step: its steps; ``then`` is called with the study that made
    the ladder, if any did. Raises what a section raises.
    """
    if not aside:
        return make(others, announce, step, study, then).sections
    last = [part for part in others if part.alone]
    with _another(aside, study, then) as other:
        main = make([part for part in others if not part.alone], announce, step, study, then)
        announce(f"what is left of {', '.join(part.name for part in aside)}")
        beside: Made = next(other)
    study.scenes.update(beside.study.scenes)
    study.others.update(beside.study.others)
    return beside.sections | main.sections | make(last, announce, step, study, then).sections


def make(parts: Sequence[Part], announce: Step, step: Step, study: Study, then: Callable[[Study], None]) -> Made:
    """Some sections, one after the other."""
    sections = {}
    for part in parts:
        announce(part.name)
        section: Callable[[Study, Step], Section] = import_module(f"rollbench.comparison.{part.module}").section
        sections[part.name] = section(study, step)
    if "ladder" in sections:
        then(study)
    return Made(sections, replace(study, results={}, computed={}))


class _Aside:
    """Lines on the terminal from the second process: which section, which step, seconds since it began."""

    def __init__(self) -> None:
        self.start = perf_counter()

    def section(self, name: str) -> None:
        """Announce a section."""
        print(f"[beside] {name} ({perf_counter() - self.start:.1f} s)", flush=True)

    def step(self, text: str) -> None:
        """Announce a step of the section."""
        print(f"[beside]   {text}", flush=True)


def _elsewhere(parts: Sequence[Part], study: Study, then: Callable[[Study], None]) -> Made:
    aside = _Aside()
    return make(parts, aside.section, aside.step, study, then)


@contextmanager
def _another(parts: Sequence[Part], study: Study, then: Callable[[Study], None]) -> Iterator[Iterator[Made]]:
    """A process that makes ``parts``, each of the two with one thread; ended where the body fails."""
    from joblib import Parallel, delayed
    from threadpoolctl import threadpool_limits

    with local(threads=1), threadpool_limits(1):
        pool: Any = Parallel(n_jobs=2, max_nbytes=None, return_as="generator")
        running = pool([delayed(_elsewhere)(list(parts), study, then)])
        try:
            yield running
        finally:
            running.close()
