"""The 3D reference of a scene: loads of the finest stored run, and their uncertainty by discretisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference import grid_parts
from rollbench.compare.reference.convergence import representative_size
from rollbench.compare.reference.grid_parts import GridParts, error_near_faces, excess_near_faces, parts
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load_run, shipped_store
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene

#: Number of the finest levels from which the uncertainty is estimated: coarser ones say little about the finest.
FITTED = 4


@dataclass(frozen=True)
class Reference:
    """The 3D reference of a scene, or a user's reference."""

    #: Name of the scene.
    scene: str
    #: Runs, coarse to fine; of a user's reference one without mesh, displacements or times.
    runs: tuple[Run, ...]
    #: Contact loads of the finest run, (n, 4) [N].
    load: Array
    #: Uncertainty of the loads by discretisation and incomplete convergence, (n, 4) [N]; zero where no level has load.
    uncertainty: Array
    #: Parts of this uncertainty.
    parts: GridParts
    #: Number of contacts that the nominal screw loads; 0: not known.
    contacts: int = 0
    #: Name of the reference; of a user's its file.
    label: str = "3D reference"
    #: Text on the uncertainty in the file of a user's reference; empty for a computed reference.
    stated: str = ""
    #: Further quantities of contacts in a user's reference, (n, 4) in SI.
    further: Mapping[str, Array] = field(default_factory=dict)
    #: Part of the uncertainty due to a free face of the nut near a contact, (n, 4) [N] (`compare.reference.grid_parts`).
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
        """Run on the finest mesh level."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs, coarse to fine."""
        return (1.0,) if self.stated else tuple(representative_size(run.settings) for run in self.runs)

    @property
    def unsettled(self) -> str:
        """Text with the status of the runs that did not fully converge; empty if all did."""
        return "; ".join(f"level {run.level} {run.status}" for run in self.runs if run.moving > 0.0)


def reference(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Return the best stored reference of a scene.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    stores
        Folders with runs; None: those of the package.

    Returns
    -------
    Reference or None
        The reference, from the `FITTED` finest stored runs; None if there is none.
    """
    runs = tuple(run for level in LEVELS if (run := load_run(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.answers)[-FITTED:]
    return reference_from_runs(scene.name, scene, runs, contacts=nominal_contacts(scene)) if runs else None


def reference_from_runs(name: str, scene: Scene, runs: tuple[Run, ...], contacts: int = 0) -> Reference:
    """Make the reference of a scene from its runs.

    Parameters
    ----------
    name
        Name of the scene.
    scene
        Scene with one set; of several sets the parts of one.
    runs
        Runs, coarse to fine.
    contacts
        Number of contacts that the nominal screw loads; 0: not known.

    Returns
    -------
    Reference
        The reference.
    """
    loads = {run.level: run.load for run in runs}
    grid, best = parts(loads, grid_parts.read_experience(shipped_store())), runs[-1]
    bars = 0.01 * mean_load(best.load) * grid.bars(loads) if grid.bar else np.zeros_like(best.load)
    lips = excess_near_faces(scene, best.load, best.level)
    beside = error_near_faces(scene, best.load, best.level) if grid.by_experience else lips
    return Reference(name, runs, best.load, bars + beside + best.moving, grid, contacts, beside_face=lips)


def uncertainty_percent(reference: Reference) -> float:
    """Return the largest uncertainty of a contact load by discretisation [% of the mean load]."""
    return float(error_percent(reference.uncertainty.max(), 0.0, reference.mean)) if reference.parts.bar else 0.0
