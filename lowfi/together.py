"""Searches that run side by side: what several of them ask for at the same time is computed as arrays in one go.

A search is written for one screw, shaft or chain of balls. It is a generator that yields tasks (the equations that it wants
to be solved next), receives their results, and returns its own result. `solve_together` runs several searches, for instance
those of simulations over time that differ in one value only, and solves alike tasks in one call: an operation on an array
of a few dozen balls costs hardly less than one on a few hundred.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Hashable, Sequence
from typing import Any, Self, TypeVar

#: Result of a search.
T = TypeVar("T")


class Task(ABC):
    """Abstract class for a computation that a search asks for."""

    @property
    @abstractmethod
    def likeness(self) -> Hashable:
        """Value that is the same for tasks that can be solved together."""

    @classmethod
    @abstractmethod
    def solve(cls, tasks: Sequence[Self]) -> Sequence[Any]:
        """Return the results of alike tasks, in their order."""


#: A search: a generator that yields tasks, is sent their results, and returns a result of type T.
Search = Generator[Task, Any, T]


def solve_together(searches: Sequence[Search[T]]) -> list[T]:
    """Run several searches side by side and return their results, in the same order.

    Of all tasks that wait, the largest number of alike ones is solved first, so that searches at the same stage meet.
    """
    results, waiting = dict[int, T](), dict[int, Task]()
    answers = dict[int, Any].fromkeys(range(len(searches)))
    while answers:
        for k, answer in answers.items():
            waiting.pop(k, None)
            try:
                waiting[k] = searches[k].send(answer)
            except StopIteration as end:
                results[k] = end.value
        alike = dict[Hashable, list[int]]()
        for k, task in waiting.items():
            alike.setdefault((type(task), task.likeness), []).append(k)
        asked = max(alike.values(), key=len, default=[])
        tasks = [waiting[k] for k in asked]
        answers = dict(zip(asked, type(tasks[0]).solve(tasks) if tasks else (), strict=True))
    return [results[k] for k in range(len(searches))]


def solve_alone(search: Search[T]) -> T:
    """Run one search and return its result."""
    return solve_together([search])[0]


class SideBySide(Task):
    """Task of one search to run several others side by side; its result is the list of theirs."""

    likeness = None

    def __init__(self, searches: Sequence[Search[Any]]) -> None:
        """Ask for the results of ``searches``."""
        self.searches = searches

    @classmethod
    def solve(cls, tasks: Sequence[Self]) -> list[list[Any]]:
        """Return the results of the searches of each task."""
        found = iter(solve_together([search for task in tasks for search in task.searches]))
        return [[next(found) for _ in task.searches] for task in tasks]
