"""The 3D reference of a scene: contact loads of the finest stored run, and their uncertainty due to the mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.reference import grid_parts
from rollbench.compare.reference.convergence import representative_size
from rollbench.compare.reference.grid_parts import GridParts, error_near_faces, excess_near_faces, parts
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load_run, shipped_store
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Number of the finest levels from which the uncertainty is estimated. Coarser levels say little about the finest.
FITTED = 4


@dataclass(frozen=True)
class Reference:
    """Contact loads of a scene with which models are compared: from the 3D reference or from a user's file."""

    #: Name of the scene.
    scene: str
    #: Runs, coarse to fine; for a user's file a single run without mesh, displacements or times.
    runs: tuple[Run, ...]
    #: Contact loads of the finest run, (n, 4) [N].
    load: Array
    #: Uncertainty of the loads due to mesh and incomplete convergence, (n, 4) [N]; zero for contacts without load.
    uncertainty: Array
    #: Parts of the uncertainty due to the mesh.
    parts: GridParts
    #: Number of contacts that are loaded in the nominal screw; 0: not known.
    contacts: int = 0
    #: Name of the reference; for a user's file, the name of the file.
    label: str = "3D reference"
    #: Text on the uncertainty in a user's file; empty for a computed reference.
    stated: str = ""
    #: Other contact quantities in a user's file, (n, 4) in SI.
    further: Mapping[str, Array] = field(default_factory=dict)
    #: Part of the uncertainty due to a free face of the nut near the contact, (n, 4) [N] (`compare.reference.grid_parts`).
    beside_face: Array | None = None

    @property
    def levels(self) -> tuple[int, ...]:
        """Mesh levels of the runs, coarse to fine; empty for a user's file."""
        return () if self.stated else tuple(run.level for run in self.runs)

    @property
    def mean(self) -> float:
        """Mean load [N] of the loaded contacts, to which errors refer (`compare.measure.mean_load`)."""
        return mean_load(self.load, self.contacts)

    @property
    def best(self) -> Run:
        """Run on the finest mesh level."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs, coarse to fine."""
        return (1.0,) if self.stated else tuple(representative_size(run.settings) for run in self.runs)

    @property
    def unsettled(self) -> str:
        """Text with the status of each run that did not fully converge; empty if all converged."""
        return "; ".join(f"level {run.level} {run.status}" for run in self.runs if run.moving > 0.0)


def reference(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Return the 3D reference of a scene from its finest stored runs.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    stores
        Folders with runs; None: those of the package.

    Returns
    -------
    Reference or None
        Contact loads and uncertainty from at most `FITTED` runs; None without a stored run.
    """
    runs = tuple(run for level in LEVELS if (run := load_run(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.answers)[-FITTED:]
    return reference_from_runs(scene.name, scene, runs, contacts=nominal_contacts(scene)) if runs else None


def reference_from_runs(name: str, scene: Scene, runs: tuple[Run, ...], contacts: int = 0) -> Reference:
    """Return the 3D reference of a scene (loads and uncertainty) from its runs on one or several mesh levels.

    Parameters
    ----------
    name
        Name of the scene.
    scene
        Scene with one nut or bearing row; one row as a scene if the shaft has several.
    runs
        Runs, coarse to fine.
    contacts
        Number of contacts that are loaded in the nominal screw; 0: not known.

    Returns
    -------
    Reference
        Loads of the finest run with their uncertainty.
    """
    loads = {run.level: run.load for run in runs}
    grid, best = parts(loads, grid_parts.read_experience(shipped_store())), runs[-1]
    bars = 0.01 * mean_load(best.load) * grid.bars(loads) if grid.bar else np.zeros_like(best.load)
    lips = excess_near_faces(scene, best.load, best.level)
    beside = error_near_faces(scene, best.load, best.level) if grid.by_experience else lips
    return Reference(name, runs, best.load, bars + beside + best.moving, grid, contacts, beside_face=lips)


def uncertainty_percent(reference: Reference) -> float:
    """Return the largest uncertainty of a contact load of the reference [% of the mean load]; zero without load."""
    return float(error_percent(reference.uncertainty.max(), 0.0, reference.mean)) if reference.parts.bar else 0.0
