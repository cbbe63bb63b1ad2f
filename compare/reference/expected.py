"""What a run of the 3D reference will take, from its scene: seconds, memory, stage by stage.

Fitted to the stored runs of 17 screws and bearings (6 to 264 contacts, four levels), each in one process beside another
on two cores of 2026: within a factor of two in time and in memory. Several processes for one run: from case 1 on level 3,
and screws of 228 and 264 contacts on level 1. Not fitted: level 5 (twice level 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rollbench.compare.errors import InputError
from rollbench.compare.reference.tasks import Task, set_ups
from rollbench.compare.running import available_GB
from rollbench.meshes.cache import StageDone

#: Seconds of the contact patches, by level: they do not depend on the number of contacts.
PATCHES = {0: 3.0, 1: 13.0, 2: 25.0, 3: 45.0, 4: 100.0, 5: 200.0}
#: Seconds a contact of the stages that do, on level 1, and how they grow with the level.
A_CONTACT = {"meshes": 0.02, "shaft section": 0.05, "screw": 0.08, "nut": 0.06, "contact loads": 0.02}
GROWTH = {0: 0.4, 1: 1.0, 2: 1.2, 3: 1.8, 4: 3.0, 5: 6.0}
#: Memory [GB]: of all that does not grow with the contacts, by level, and a contact.
BASE_GB = {0: 0.6, 1: 0.65, 2: 0.9, 3: 1.3, 4: 2.2, 5: 4.4}
CONTACT_GB = 0.007
#: What a second process saves of the time of the stages that it shares, and adds to the memory: a share, or where there are
#: so many contacts that it makes patches alone (`hifi.setup.TOGETHER`), a share of what does not grow with them.
SHARED, FASTER, MORE, TOGETHER = ("meshes", "patches", "ball", "shaft section", "screw", "nut"), 1.7, 0.7, 160
PATCHES_ALONE = 0.68
#: Order of the stages, by the names that `hifi.setup.prepare` gives them.
STAGES = ("meshes", "patches", "shaft section", "screw", "nut", "ball", "contact loads")


@dataclass(frozen=True)
class Expected:
    """Seconds of each stage of a run, and its peak of memory [GB]."""

    stages: dict[str, float]
    memory_GB: float

    @property
    def seconds(self) -> float:
        """Of all stages."""
        return sum(self.stages.values())


def expected(task: Task) -> Expected:
    """Seconds and memory that a task will take."""
    by_bodies = [len(up.sides) * up.bodies.ball_count for up in set_ups(task.scenes, task.level)]
    contacts = sum(by_bodies)
    times = len(task.scenes) * (6 if task.ablate else 1)
    stages = {name: GROWTH[task.level] * A_CONTACT.get(name, 0.0) * contacts for name in STAGES}
    stages |= {"patches": len(by_bodies) * PATCHES[task.level], "ball": float(len(by_bodies))}
    stages["contact loads"] *= times
    memory = BASE_GB[task.level] + CONTACT_GB * contacts
    if task.processes > 1:
        stages |= {name: stages[name] / FASTER for name in SHARED}
        memory += MORE * memory if contacts <= TOGETHER else PATCHES_ALONE * BASE_GB[task.level]
    return Expected(stages, memory)


def need_memory(tasks: Sequence[Task], workers: int) -> float:
    """Peak of memory [GB] of so many of the tasks at the same time. Raises InputError where there is less."""
    each = sorted((expected(task).memory_GB for task in tasks), reverse=True)
    peak, free = sum(each[:workers]), available_GB()
    if free is not None and peak > free:
        largest = max(tasks, key=lambda task: expected(task).memory_GB)
        fewer = f"`workers={workers - 1}`, " if workers > 1 else ""
        raise InputError(
            "this machine",
            "memory",
            f"{free:.1f} GB free",
            f"about {peak:.1f} GB for {largest.label}",
            f"end other programs, take {fewer}a coarser level (`levels=1`), or a cluster (`backend=dask`)",
        )
    return peak


def duration(seconds: float) -> str:
    """A duration in words, with one number.

    >>> duration(42.0), duration(600.0), duration(9000.0)
    ('40 s', '10 min', '2.5 h')
    """
    if seconds < 90.0:
        return f"{10 * max(round(seconds / 10), 1)} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400.0 else f"{seconds / 3600:.1f} h"


class Progress:
    """Stage, share and time left of one task, from what its stages were expected to take and have taken.

    ``stages``: name and expected seconds of those to come, the contact loads of every scene one of them; ``after``:
    expected seconds of the tasks that follow, which are left too.
    """

    def __init__(self, task: Task, after: float = 0.0) -> None:
        """Nothing is done yet."""
        self.label, self.after = task.label, after
        stages, scenes = expected(task).stages, len(task.scenes)
        loads = stages.pop("contact loads")
        self.stages = [*stages.items(), *[("contact loads", loads / scenes)] * scenes]
        self.done = self.computed = 0.0

    @property
    def under_way(self) -> str:
        """The task, and the stage that is not done yet."""
        return f"{self.label}: {self.stages[0][0]}" if self.stages else self.label

    def line(self, text: str, spent: float) -> str:
        """The line for ``text``, a `StageDone` at the end of a stage, ``spent`` seconds after the task began.

        Stages from the cache say nothing of the machine's pace.
        """
        stage = next((s for s in self.stages if isinstance(text, StageDone) and s[0] == text.stage), None)
        if stage is None or not isinstance(text, StageDone):
            return f"{self.label}: {text}"
        self.stages.remove(stage)
        self.done += stage[1]
        self.computed += 0.0 if text.cached else stage[1]
        left = sum(seconds for _, seconds in self.stages)
        pace = min(max(spent / self.computed, 0.1), 10.0) if self.computed else 1.0
        total = f"about {duration(pace * (left + self.after))} left"
        return f"{self.label}: {text}; {self.done / (self.done + left):.0%}, {total}{' in all' if self.after else ''}"
