"""The three rigidities of a nut as ISO 3408-4 separates them, beside the 3D reference and beside catalogues."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.loading import solve_scaled
from rollbench.comparison.models.registry import DEFAULT, Options
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.estimate import Reference
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force, rigidities
from rollbench.meshes.parts import Scene
from rollbench.reports.records import Cell, Quantity, Table

#: Displacement without loads over that with them up to which it is taken as none: the reference has no run without loads.
STARTS = 0.01


def displacement_3d(scene: Scene, found: Reference) -> float:
    """Axial displacement [m] of the screw's section at the nut's centre in the finest run of the 3D reference."""
    line = found.best.centreline
    return float(np.interp(scene.nut.position, line[:, 0], line[:, 3]))


def reference_row(study: Study, name: str) -> dict[str, Cell] | None:
    """Rigidities [N/um] of a scene with a stored 3D reference; None without one, without axial load, or where the screw is
    displaced without loads, from where nothing of the reference counts."""
    scene, found = study.scene(name), study.reference(name)
    if found is None:
        return None
    result = study.solve(name, DEFAULT)
    force, moved = axial_force(result), axial_displacement(scene, result)
    bare = solve_scaled(scene, 0.0, DEFAULT, Options(discretisation=False, engine="interpreted"))
    if abs(axial_displacement(scene, bare)) > STARTS * abs(moved):
        return None
    try:
        stages = rigidities(scene, force, moved)
    except ValueError:
        return None
    if stages is None or stages.bodies is None or stages.unequal is None:
        return None
    return {
        "scene": name,
        "load": 1e-3 * abs(force),
        "contacts": 1e-6 * stages.contacts,
        "bodies": 1e-6 * stages.bodies,
        "unequal": 1e-6 * stages.unequal,
        "reference": 1e-6 * force / displacement_3d(scene, found),
    }


def stages_table(
    study: Study, catalogue: Sequence[tuple[str, float, dict[str, float | None]]], names: Sequence[str]
) -> Table:
    """Catalogue sizes with the printed rigidity, then scenes with a 3D reference."""
    rows: list[dict[str, Cell]] = []
    for name, force, stages in catalogue:
        row: dict[str, Cell] = {"scene": name, "load": 1e-3 * force, **stages, "reference": None}
        for key in ("contacts", "bodies", "unequal"):
            value, printed = stages[key], stages["printed"]
            if value and printed:
                row[f"share_{key}"] = 1.0 + float(error_percent(printed, value)) / 100.0
        rows.append(row)
    rows += [row for row in (reference_row(study, name) for name in names) if row is not None]
    columns = (
        Quantity("scene", "scene", "", "s"),
        Quantity("load", "axial load", "kN", "g3"),
        Quantity("contacts", "contacts alone", "N/um", "g4"),
        Quantity("bodies", "with the bodies", "N/um", "g4"),
        Quantity("unequal", "with unequal loads", "N/um", "g4"),
        Quantity("reference", "3D reference", "N/um", "g4"),
        Quantity("printed", "catalogue", "N/um", "g4"),
        Quantity("share_contacts", "catalogue over contacts", "", ".3f"),
        Quantity("share_bodies", "over bodies", "", ".3f"),
        Quantity("share_unequal", "over unequal", "", ".3f"),
    )
    note = (
        "Axial load over axial displacement, as ISO 3408-4 separates it: equal balls between rigid bodies; with the "
        "widening of the nut and the squeezing of the screw (thick tubes); with the unequal loads that the default model "
        "finds, at the nut's centre. What a maker counts in besides is not printed: ISO 3408-4's factor of the tolerance "
        "class, the nut's flange and its mounting lie between. Catalogue sizes as scenes have what is usual where the "
        "catalogue is silent. Scenes that are displaced without loads are left out."
    )
    return Table(
        "external-rigidities", "The three rigidities of a nut, beside 3D and beside catalogues", columns, rows, note
    )
