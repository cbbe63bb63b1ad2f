"""Page on external evidence: other programs, makers' catalogues and textbooks, computed and published values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare.cases.external import evidence as external
from rollbench.compare.cases.external.evidence import PREFIX, assumptions
from rollbench.compare.evidence import Evidence, computations_by_table, evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.loading import solve_scaled
from rollbench.compare.models.modelling import UNSEEN
from rollbench.compare.models.registry import DEFAULT, Options
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.sections.verdicts import printed_table
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force, rigidities
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Cell, Figure, Panel, Quantity, Section, Series, Table, Text

#: Titles of the tables.
TITLES = {
    "external-masta": "A deep-groove bearing by MASTA",
    "external-nsk": "One ball of a screw-support bearing by NSK's programs",
    "external-harris": "The 218 bearing of the textbooks, recomputed",
    "external-sjovall": "Load zone of half the circumference",
    "external-contact": "Rolling contact with creepage and spin: computed values and those of the program CONTACT",
    "external-vm63": "Sphere on a rigid plane, Ansys's verification case 63",
    "external-snfa": "A catalogue of SNFA that holds its contact angles",
    "external-gmn": "Preloaded bearing pairs from GMN's catalogue: printed and computed stiffness",
    "external-thk": "Ball nuts of THK and HIWIN",
    "external-equivalent": "Equivalent loads of preloaded nuts and of bearings: published and computed",
}
#: Names of their sources in the figure.
SOURCES = {
    "external-masta": "MASTA",
    "external-nsk": "NSK's programs",
    "external-harris": "textbooks, 218 bearing",
    "external-sjovall": "Sjövall, load zone",
    "external-contact": "CONTACT",
    "external-vm63": "Ansys, case 63",
    "external-snfa": "SNFA",
    "external-gmn": "GMN",
    "external-thk": "THK and HIWIN",
    "external-equivalent": "makers, equivalent loads",
}

#: Displacement without loads over that with them up to which it is taken as none: the reference has no run without loads.
STARTS = 0.01


def summary(found: Sequence[Evidence]) -> str:
    """Return how many entries come out, in one sentence."""
    judged = [e for e in found if e.printed.cls != "open"]
    good = sum(e.agrees is True for e in judged)
    of = Counter(e.verdict for e in judged)
    return (
        f"{good} of {len(judged)} published values and claims agree. Of these, {of['reproduced']} agree to the digits that "
        f"the same theory must give, {of['band']} within a band whose origin is stated, {of['identity']} by "
        f"arithmetic on printed numbers, {of['only as printed']} only if the catalogue's simplification is "
        f"repeated. {len(found) - len(judged)} more are shown but left open, because their basis is not "
        "printed."
    )


def assumed_table(study: Study) -> Table:
    """Return the table of the assumptions made to compute each external case."""
    rows: list[dict[str, Cell]] = []
    for name, thing in study.used.items():
        if name.startswith(PREFIX) and isinstance(thing, Scene | Assembly):
            rows += [{"case": name, "assumed": text} for text in thing.assumed]
    for name, texts in assumptions().items():
        rows += [{"case": PREFIX + name, "assumed": text} for text in texts]
    columns = (Quantity("case", "case or scene", "", "s"), Quantity("assumed", "inferred or chosen to run it", "", "s"))
    return Table(
        "external-assumed", "Inputs that the publications leave open, and the values assumed for them", columns, rows
    )


def agreement_figure(found: Sequence[Evidence]) -> Figure:
    """Draw the error of every number of class hard and band against the published one, by source."""
    errors: dict[str, list[float]] = {}
    for e in found:
        if e.printed.cls in ("hard", "band") and e.error_percent is not None:
            errors.setdefault(SOURCES[e.printed.table], []).append(e.error_percent)
    points = [(float(k), error) for k, percents in enumerate(errors.values(), start=1) for error in percents]
    series = (Series("error", [x for x, _ in points], [y for _, y in points], "markers"),)
    panel = Panel("computed against published", "", "error / %", series, names=list(errors))
    caption = "Numbers of class hard and band; claims and open entries are in the tables."
    return Figure("external-errors", "Difference between computed and published values", (panel,), caption, columns=1)


def catalogue_rows(study: Study) -> list[tuple[str, float, dict[str, float | None]]]:
    """Return name, axial load [N] and rigidities [N/um] (by included effects, and printed) of each catalogue size."""
    out: list[tuple[str, float, dict[str, float | None]]] = []
    for size in (*external.THK, *external.HIWIN):
        name = external.scene_name(size)
        scene = study.scene(name)
        force = scene.loads[0].force[2]
        alone, bodies = external.rigidity_by_parts(scene, force)
        solved = external.rigidity_unequal_loads(study, name, DEFAULT)
        printed = entry("external-thk", f"rigidity_{size}").value
        unequal = 1e-6 * solved if solved else None
        stages = {"contacts": 1e-6 * alone, "bodies": 1e-6 * bodies, "unequal": unequal, "printed": printed}
        out.append((name, force, stages))
    return out


# --- the three rigidities of a nut as ISO 3408-4 separates them, beside the 3D reference and beside catalogues


def displacement_3d(scene: Scene, found: Reference) -> float:
    """Return the axial displacement of the screw at the nut's centre in the finest run of the 3D reference [m]."""
    line = found.best.centreline
    return float(np.interp(scene.nut.position, line[:, 0], line[:, 3]))


def reference_row(study: Study, name: str) -> dict[str, Cell] | None:
    """Return the row of rigidities [N/um] of a scene: by effects in the model, and by its stored 3D reference.

    None without a stored reference, without axial load, or where the screw is displaced even at zero load, since the
    reference's displacements do not start from there.
    """
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
    """Return the table of rigidities by included effects: catalogue sizes, then scenes with a 3D reference."""
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


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("values of other programs, makers and textbooks")
    tables = [name for name in computations_by_table() if name.startswith(PREFIX)]
    found = evidence(study, *tables)
    step("three rigidities of ball nuts")
    rigid = stages_table(study, catalogue_rows(study), UNSEEN)
    inferred = float(np.round(external.gmn_rms_percent(), 2))
    text = (
        (
            "Values from neither this project nor the sources of its models: other programs, makers' "
            "catalogues, textbooks. Each is a row of the gate by its class, with what was inferred to compute "
            "it."
        ),
        (
            "With one conformity inferred for the whole series, the rigidities of GMN's catalogue are met to "
            f"{inferred:g} % RMS; one of them is an error of the catalogue."
        ),
    )
    items: tuple[Text | Figure | Table, ...] = (
        Text(text),
        agreement_figure(found),
        *(printed_table(name, TITLES[name], [e for e in found if e.printed.table == name]) for name in tables),
        rigid,
        assumed_table(study),
    )
    return Section("external", "Comparison with other programs, catalogues and textbooks", items, conclusion=summary(found))
