"""Report page that compares computed values with those of other programs, makers' catalogues and textbooks."""

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

#: Titles of the tables, by name of the printed table.
TITLES = {
    "external-masta": "Deep-groove ball bearing: displacement and life by the program MASTA and computed",
    "external-nsk": "Contact of one ball of a screw-support bearing: by NSK's programs and computed",
    "external-harris": "Textbooks' 218 angular-contact bearing under thrust: published and computed",
    "external-sjovall": "Bearing with a load zone of half the circumference: Sjövall's load distribution and computed",
    "external-contact": "Rolling contact with creepage and spin: computed values and those of the program CONTACT",
    "external-vm63": "Elastic sphere on a rigid plane (Ansys's verification case 63): contact radius",
    "external-snfa": "SNFA's catalogue, which keeps contact angles constant: rigidity and lift-off load",
    "external-gmn": "Preloaded bearing pairs from GMN's catalogue: printed and computed stiffness",
    "external-thk": "Ball nuts of THK and HIWIN: printed and computed rigidity and drag torque",
    "external-equivalent": "Equivalent loads of preloaded nuts and of bearings: published and computed",
}
#: Names of the publishers in the figure, by name of the printed table.
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

#: Largest axial displacement without loads over that with loads that is neglected. Scenes with more are left out, because
#: the 3D reference has no run without loads to subtract.
STARTS = 0.01


def agreement_sentence(found: Sequence[Evidence]) -> str:
    """Return the sentence on how many published values and claims agree with the computed ones.

    ``found``: published values and claims with what is computed for them.
    """
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


def assumptions_table(study: Study) -> Table:
    """Return the table of assumptions made where a publication leaves inputs open."""
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
    """Draw the errors of computed values against published ones of class hard and band, by publisher."""
    errors: dict[str, list[float]] = {}
    for e in found:
        if e.printed.cls in ("hard", "band") and e.error_percent is not None:
            errors.setdefault(SOURCES[e.printed.table], []).append(e.error_percent)
    points = [(float(k), error) for k, percents in enumerate(errors.values(), start=1) for error in percents]
    series = (Series("error", [x for x, _ in points], [y for _, y in points], "markers"),)
    panel = Panel("computed against published", "", "error / %", series, names=list(errors))
    caption = "Numbers of class hard and band; claims and open entries are in the tables."
    return Figure("external-errors", "Difference between computed and published values", (panel,), caption, columns=1)


def catalogue_rigidities(study: Study) -> list[tuple[str, float, dict[str, float | None]]]:
    """Return the axial rigidities of each catalogue nut, computed with growing detail and printed.

    Each entry: name of the scene; axial load [N]; rigidities [N/um] of the "contacts" alone, with the "bodies", with
    "unequal" ball loads, and "printed" in the catalogue, None where unknown.
    """
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


# --- three rigidities of a nut as ISO 3408-4 separates them, compared with the 3D reference and catalogues


def displacement_in_3d(scene: Scene, found: Reference) -> float:
    """Return the screw's axial displacement [m] at the nut's centre by the finest run ``found`` of the 3D reference."""
    line = found.best.centreline
    return float(np.interp(scene.nut.position, line[:, 0], line[:, 3]))


def nut_rigidity_row(study: Study, name: str) -> dict[str, Cell] | None:
    """Return the table row of a nut's rigidities [N/um]: by the effects included in the model, and by the 3D reference.

    None without a stored reference, without axial load, or if the screw is displaced at zero load, which the
    reference's displacements do not subtract.
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
        "reference": 1e-6 * force / displacement_in_3d(scene, found),
    }


def rigidities_table(
    study: Study, catalogue: Sequence[tuple[str, float, dict[str, float | None]]], names: Sequence[str]
) -> Table:
    """Return the table of nut rigidities by the effects included: catalogue sizes, then scenes with a 3D reference.

    ``catalogue``: result of `catalogue_rigidities`; ``names``: scenes to compare with the 3D reference.
    """
    rows: list[dict[str, Cell]] = []
    for name, force, stages in catalogue:
        row: dict[str, Cell] = {"scene": name, "load": 1e-3 * force, **stages, "reference": None}
        for key in ("contacts", "bodies", "unequal"):
            value, printed = stages[key], stages["printed"]
            if value and printed:
                row[f"share_{key}"] = 1.0 + float(error_percent(printed, value)) / 100.0
        rows.append(row)
    rows += [row for row in (nut_rigidity_row(study, name) for name in names) if row is not None]
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
        "external-rigidities",
        "Rigidity of ball nuts by the effects included: computed, by the 3D reference, in catalogues",
        columns,
        rows,
        note,
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report's section on values of other programs, makers' catalogues and textbooks."""
    step("values of other programs, makers and textbooks")
    tables = [name for name in computations_by_table() if name.startswith(PREFIX)]
    found = evidence(study, *tables)
    step("three rigidities of ball nuts")
    rigid = rigidities_table(study, catalogue_rigidities(study), UNSEEN)
    inferred = float(np.round(external.gmn_rms_percent(), 2))
    text = (
        (
            "Values from neither this project nor the publications of its models: other programs, makers' "
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
        assumptions_table(study),
    )
    return Section(
        "external", "Comparison with other programs, catalogues and textbooks", items, conclusion=agreement_sentence(found)
    )
