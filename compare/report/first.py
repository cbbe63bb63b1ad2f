"""The first report of a machine: what it leaves out and what brings that back, and one shipped run recomputed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference.computing import compute
from rollbench.compare.reference.store import load
from rollbench.compare.reference.tasks import Task
from rollbench.compare.report.pages import Listed
from rollbench.compare.running import cores, gmsh_fault
from rollbench.compare.scenes import catalogue
from rollbench.meshes.libraries import MESHING, PICTURES, install, pip, version
from rollbench.meshes.loads import mean_load
from rollbench.reports.content import FieldPicture, LoadedScrew, Section
from rollbench.reports.offscreen import fault as drawing_fault

#: Sections that take most of a report's time: they come with ``--all``, with ``--fresh``, and by name.
COSTLY = frozenset({"pictures", "friction", "friction-screw", "rolling", "verification", "stability"})
#: Scene and level of the shipped run that is recomputed: a quarter of a minute on one core.
CHECKED, LEVEL = "unseen-four-point", 1
#: Largest difference [% of the mean load] that another processor's round-off explains.
AGREES = 1e-3


@dataclass(frozen=True)
class LeftOut:
    """Sections or files that a report leaves out, why, and the command that brings them back."""

    names: tuple[str, ...]
    why: str
    remedy: str

    def __str__(self) -> str:
        """What, why, and the command."""
        return f"{', '.join(self.names)}: {self.why}; {self.remedy}"


def kept_parts(parts: Sequence[Listed], *, named: bool, everything: bool) -> tuple[list[Listed], list[LeftOut]]:
    """Sections that can be made here, and those left out: costly ones unless named or everything is asked for, those that
    mesh where gmsh cannot be loaded."""
    left: list[LeftOut] = []
    out = {part.name for part in parts if part.name in COSTLY} if not (named or everything) else set()
    if out:
        names = tuple(part.name for part in parts if part.name in out)
        left.append(LeftOut(names, "they take most of the time", "rollbench report --all makes them too"))
    meshing = [part for part in parts if (part.meshes or part.meshed) and part.name not in out]
    fault = gmsh_fault() if meshing else ""
    if fault:
        names = tuple(f"{part.name} ({part.meshed})" if part.meshed else part.name for part in meshing)
        left.append(LeftOut(names, f"gmsh cannot be loaded ({fault})", install(MESHING, PICTURES)))
        out |= {part.name for part in meshing if part.meshes}
    return [part for part in parts if part.name not in out], left


def lacking(sections: Iterable[Section]) -> list[LeftOut]:
    """What a report leaves out because a package of the extra report is not installed, and the 3D pictures of its sections
    where this machine cannot draw them."""
    left = []
    if version("trimesh") is None:
        left.append(LeftOut(("the view that can be turned",), "trimesh is not installed", pip("trimesh")))
    if any(isinstance(item, LoadedScrew | FieldPicture) for section in sections for item in section.items) and (
        why := drawing_fault()
    ):
        left.append(LeftOut(("3D pictures",), why, install(PICTURES)))
    return left


@dataclass(frozen=True)
class LiveCheck:
    """A shipped run recomputed: scene, level, largest difference of a contact load [% of the mean load], seconds."""

    scene: str
    level: int
    percent: float
    seconds: float

    @property
    def agrees(self) -> bool:
        """Whether the difference is round-off."""
        return self.percent <= AGREES

    def __str__(self) -> str:
        """What was computed, and whether it agrees."""
        verdict = "agrees" if self.agrees else "DOES NOT AGREE"
        return (
            f"{self.scene}, level {self.level}, recomputed in {self.seconds:.0f} s, {verdict} with the "
            f"shipped run: contact loads differ by up to {self.percent:.1g} % of the mean load"
        )


def live_check(stores: Sequence[Path] | None, step: Callable[[str], None]) -> LiveCheck | None:
    """Recompute one stored run, without any cache; None where no store has it under this machine's key."""
    scene = catalogue.scene(CHECKED)
    stored = load(scene, LEVEL, stores=stores)
    if stored is None:
        return None
    start = perf_counter()
    (run,) = compute(Task((scene,), LEVEL, processes=cores()), step)
    mean = mean_load(stored.load)
    percent = float(np.abs(error_percent(run.load, stored.load, mean)).max()) if run.status == "converged" else float("inf")
    return LiveCheck(CHECKED, LEVEL, percent, perf_counter() - start)
