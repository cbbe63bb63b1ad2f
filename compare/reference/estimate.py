"""The 3D reference of a scene: loads of its finest stored run, what the mesh leaves uncertain in them, and a summary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference import grid_parts
from rollbench.compare.reference.convergence import representative_size
from rollbench.compare.reference.grid_parts import GridParts, left_out, parts, too_large
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load, shipped_store
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Levels that a scene's uncertainty is taken from, the finest: the coarsest of more say least of the finest.
FITTED = 4


@dataclass(frozen=True)
class Reference:
    """The 3D reference of a scene: runs coarse to fine, loads of the finest ``(n, 4)`` [N], their uncertainty ``(n, 4)``
    [N] by discretisation and by what the finest did not settle by, zero where no level has load; its parts; how many
    contacts the nominal screw loads, zero where that is not known; what of the uncertainty contacts have by a free face
    of the nut beside them ``(n, 4)`` [N] (`compare.reference.grid_parts`).

    Of a user's own reference: label, its file; stated, what that says of itself; further, what it says of contacts besides
    ``(n, 4)`` [SI] by quantity; one run without mesh, displacements or seconds."""

    scene: str
    runs: tuple[Run, ...]
    load: Array
    uncertainty: Array
    parts: GridParts
    contacts: int = 0
    label: str = "3D reference"
    stated: str = ""
    further: Mapping[str, Array] = field(default_factory=dict)
    beside_face: Array | None = None

    @property
    def levels(self) -> tuple[int, ...]:
        """Mesh levels of the runs."""
        return () if self.stated else tuple(run.level for run in self.runs)

    @property
    def mean(self) -> float:
        """Mean contact load [N], see `meshes.loads.mean_load`."""
        return mean_load(self.load, self.contacts)

    @property
    def best(self) -> Run:
        """The finest run."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs."""
        return (1.0,) if self.stated else tuple(representative_size(run.settings) for run in self.runs)

    @property
    def unsettled(self) -> str:
        """What is said of runs that did not settle; empty where all did."""
        return "; ".join(f"level {run.level} {run.status}" for run in self.runs if run.moving > 0.0)


def reference(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Best stored reference of a scene, its `FITTED` finest runs, or None."""
    runs = tuple(run for level in LEVELS if (run := load(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.answers)[-FITTED:]
    return reference_of(scene.name, scene, runs, contacts=nominal_contacts(scene)) if runs else None


def reference_of(name: str, scene: Scene, runs: tuple[Run, ...], contacts: int = 0) -> Reference:
    """Reference of a scene (of one set of several: its parts) by runs, coarse to fine; contacts: see `Reference`."""
    loads = {run.level: run.load for run in runs}
    grid, best = parts(loads, grid_parts.read(shipped_store())), runs[-1]
    bars = 0.01 * mean_load(best.load) * grid.bars(loads) if grid.bar else np.zeros_like(best.load)
    lips = too_large(scene, best.load, best.level)
    beside = left_out(scene, best.load, best.level) if grid.by_experience else lips
    return Reference(name, runs, best.load, bars + beside + best.moving, grid, contacts, beside_face=lips)


def uncertainty_percent(reference: Reference) -> float:
    """What discretisation leaves uncertain in any contact load of a reference at most, in per cent of its mean load."""
    return float(error_percent(reference.uncertainty.max(), 0.0, reference.mean)) if reference.parts.bar else 0.0
