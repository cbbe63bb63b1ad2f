"""Report sections that compare computed values with other programs, makers' catalogues and textbooks.

A further section shows the influence of the surface at which the nut is fixed, on contact loads, life and rigidity.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.cases.external import evidence as external
from rollbench.compare.cases.external.evidence import PREFIX, scene_name_of_catalogue_size
from rollbench.compare.evidence import PrintedEntryComparison, computations_with_function, evidence
from rollbench.compare.measure import error_percent, load_error, mean_load
from rollbench.compare.models.loading import solve_with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import FLANGE, estimate_model_error, model_errors_on_random_screws
from rollbench.compare.models.modelling import UNSEEN
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry
from rollbench.compare.reference.estimate import load_error_near_faces, mesh_uncertainty, read_uncertainty_of_other_scenes
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.template import RIM, THICK
from rollbench.compare.sections.verdicts import printed_numbers_table
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.life import basic_rating_life
from rollbench.lowfi.rating.rigidity import axial_force, three_axial_rigidities
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Flange, NutHeld, Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: Printed tables: name of the publisher in the figure, title of the table.
TABLES = {
    "external-masta": ("MASTA", "Deep-groove ball bearing: displacement and life, computed, and by the program MASTA"),
    "external-nsk": ("NSK's programs", "Contact of one ball of a screw-support bearing: computed, and by NSK's programs"),
    "external-harris": (
        "textbooks, 218 bearing",
        "Textbooks' 218 angular-contact bearing under thrust: published and computed",
    ),
    "external-sjovall": (
        "Sjövall, load zone",
        "Bearing with a load zone of half the circumference: load distribution, computed, and by Sjövall",
    ),
    "external-contact": (
        "CONTACT",
        "Rolling contact with creepage and spin: computed values and those of the program CONTACT",
    ),
    "external-vm63": (
        "Ansys, case 63",
        "Elastic sphere on a rigid plane (Ansys's verification case 63): published and computed radius",
    ),
    "external-snfa": (
        "SNFA",
        "Preloaded bearing pair of SNFA's catalogue: printed and computed rigidity and lift-off load",
    ),
    "external-gmn": ("GMN", "Preloaded bearing pairs from GMN's catalogue: printed and computed stiffness"),
    "external-thk": ("THK and HIWIN", "Ball nuts of THK and HIWIN: printed and computed rigidity and drag torque"),
    "external-equivalent": (
        "makers, equivalent loads",
        "Equivalent loads of preloaded nuts and of bearings: published and computed",
    ),
}

#: Axial displacement without loads, divided by the displacement with loads, up to which it is neglected. Scenes with a
#: larger ratio are left out, because the 3D reference has no solution without loads to subtract.
STARTS = 0.01


def agreement_sentence(found: Sequence[PrintedEntryComparison]) -> str:
    """Return the sentence on how many published values and claims agree with the computed ones.

    ``found``: values and claims published by other programs, makers and textbooks, each with computed value and verdict.
    """
    identities = sum(e.verdict == "identity" for e in found)
    judged = [e for e in found if e.printed.entry_class != "open" and e.verdict != "identity"]
    good = sum(e.agrees_with_printed is True for e in judged)
    of = Counter(e.verdict for e in judged)
    return (
        f"{good} of {len(judged)} published values and claims agree with the computed ones. Of these, {of['reproduced']} "
        f"agree to the digits that the same theory must give, {of['band']} within a band whose origin is stated, "
        f"{of['only as printed']} only if the catalogue's simplification is repeated. {identities} more follow from other "
        f"printed numbers and judge no model; {len(found) - len(judged) - identities} are shown but open, because their "
        "basis is not printed."
    )


def assumptions_table(cache: SceneResultCache) -> Table:
    """Return the table of assumptions made where a publication leaves inputs open.

    ``cache``: lists the scenes used so far; the table has a row for each assumption of these scenes.
    """
    texts = {name: scene.assumed for name, scene in cache.used_scenes.items() if name.startswith(PREFIX)}
    texts |= {
        PREFIX + name: tuple(case["assumed"]) for name, case in external.external_inputs().items() if "assumed" in case
    }
    rows = [{"example": name, "assumed_input": text} for name, several in texts.items() for text in several]
    title = "Inputs that the publications do not print, and what is assumed for them"
    return Table.from_rows("external-assumed", title, rows)


def agreement_figure(found: Sequence[PrintedEntryComparison]) -> Figure:
    """Draw the errors [%] of computed values against published ones, with a column of markers for each publisher.

    Only values of the classes "hard" (same theory) and "band" (stated tolerance) count. ``found``: published values with
    the computed ones.
    """
    errors: dict[str, list[float]] = {}
    for e in found:
        if e.printed.entry_class in ("hard", "band") and e.error_percent is not None:
            errors.setdefault(TABLES[e.printed.table][0], []).append(e.error_percent)
    points = [(float(k), error) for k, percents in enumerate(errors.values(), start=1) for error in percents]
    series = (Series("error", [x for x, _ in points], [y for _, y in points], "markers"),)
    title = "error of the computed value against the published one"
    panel = Panel(title, "", "error_percent", series, abscissa_names=list(errors))
    caption = (
        "Only published numbers that follow from the theory used here, or that are judged within a tolerance; the tables "
        "show all."
    )
    title = "Errors of computed against published values, by publisher"
    return Figure("external-errors", title, (panel,), caption, columns=1)


def catalogue_nut_rigidity_row(cache: SceneResultCache, size: str) -> Row:
    """Return the table row of a catalogue nut's rigidities [N/um]: with more and more effects, and as its maker prints it.

    ``cache``: gives solved scenes; ``size``: name of the catalogue size.
    """
    name = scene_name_of_catalogue_size(size)
    scene = cache.built_in_scene(name)
    force = scene.loads[0].force[2]
    alone, bodies = external.nut_rigidities_without_and_with_bodies(scene, force)
    solved = external.nut_rigidity_with_unequal_loads(cache, name, DEFAULT)
    printed = printed_entry("external-thk", f"rigidity_{size}").value
    stages = {"contacts": 1e-6 * alone, "bodies": 1e-6 * bodies, "unequal_loads": 1e-6 * solved if solved else None}
    row: Row = {"scene": name, "axial_load_kN": 1e-3 * force}
    row |= {f"rigidity_of_{key}": value for key, value in stages.items()}
    row |= {"rigidity_reference": None, "rigidity_catalogue": printed}
    return row | {f"catalogue_share_of_{key}": share_of_computed(printed, value) for key, value in stages.items()}


def share_of_computed(printed: float | None, value: float | None) -> float | None:
    """Return a printed value divided by the computed one; None if either is not known."""
    return 1.0 + float(error_percent(printed, value)) / 100.0 if value and printed else None


# --- three rigidities of a nut as ISO 3408-4 separates them, compared with the 3D reference and catalogues


def nut_rigidity_row(cache: SceneResultCache, name: str) -> Row | None:
    """Return the table row of a nut's rigidities [N/um]: with more and more effects in the model, and by the 3D reference.

    ``cache``: gives solved scenes and stored 3D references; ``name``: name of the scene. Returns None without a stored 3D
    reference, without axial load, if a rigidity is not defined, or if the screw is displaced at zero load (the 3D
    displacement includes this displacement, so that load divided by displacement would not be the rigidity).
    """
    scene, found = cache.built_in_scene(name), cache.stored_reference(name)
    if found is None:
        return None
    result = cache.solve_once(name, DEFAULT)
    force, moved = axial_force(result), float(motion_at(result, scene.nut.position)[2])
    bare = solve_with_scaled_loads(scene, 0.0, DEFAULT, ModelOptions(estimate_beam_mesh_error=False))
    if abs(motion_at(bare, scene.nut.position)[2]) > STARTS * abs(moved):
        return None
    try:
        stages = three_axial_rigidities(scene, force, moved)
    except ValueError:
        return None
    if stages is None or stages.with_bodies is None or stages.with_unequal_loads is None:
        return None
    line = found.best.centreline
    return {
        "scene": name,
        "axial_load_kN": 1e-3 * abs(force),
        "rigidity_of_contacts": 1e-6 * stages.contacts_only,
        "rigidity_of_bodies": 1e-6 * stages.with_bodies,
        "rigidity_of_unequal_loads": 1e-6 * stages.with_unequal_loads,
        "rigidity_reference": 1e-6 * force / float(np.interp(scene.nut.position, line[:, 0], line[:, 3])),
    }


def nut_rigidities_table(cache: SceneResultCache) -> Table:
    """Return the table of nut rigidities with more and more effects: catalogue sizes, then scenes with a 3D reference.

    ``cache``: gives solved scenes and stored 3D references.
    """
    rows = [catalogue_nut_rigidity_row(cache, size) for size in (*external.THK, *external.HIWIN)]
    rows += [row for name in UNSEEN if (row := nut_rigidity_row(cache, name)) is not None]
    note = (
        "Axial load over axial displacement. Contacts alone: equally loaded balls between rigid bodies; contacts and "
        "bodies: nut and screw deform radially as thick tubes, too; unequal contact loads: by the default model, at the "
        "nut's centre. What else makers include is not printed (ISO 3408-4's factor of the tolerance class, flange, "
        "mounting). Dimensions that a catalogue does not print have usual values. Scenes whose screw is displaced without "
        "loads are left out."
    )
    title = "Axial rigidity of ball nuts: computed with more and more effects, by the 3D reference, and in catalogues"
    return Table.from_rows("external-rigidities", title, rows, note)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on values of other programs, makers' catalogues and textbooks.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("values of other programs, makers and textbooks")
    tables = [name for name in computations_with_function() if name.startswith(PREFIX)]
    found = evidence(cache, *tables)
    step("three rigidities of ball nuts")
    inferred = float(np.round(external.gmn_rigidity_rms_error_percent(), 2))
    text = (
        (
            "Values from neither this project nor the publications of its models: other programs, makers' catalogues, "
            "textbooks. Each value is judged by the class of its entry; the last table lists the assumed inputs."
        ),
        (
            "With one conformity inferred for the whole series, the rigidities of GMN's catalogue are "
            f"met to {inferred:g} % RMS; one printed rigidity is an error of the catalogue."
        ),
    )
    items: tuple[Text | Figure | Table, ...] = (
        Text(text),
        agreement_figure(found),
        *(printed_numbers_table(name, TABLES[name][1], [e for e in found if e.printed.table == name]) for name in tables),
        nut_rigidities_table(cache),
        assumptions_table(cache),
    )
    title = "Computed values compared with other programs, makers' catalogues and textbooks"
    return Section("external", title, items, conclusion=agreement_sentence(found))


#: Catalogue sizes of two makers, by the keys of their printed rigidities.
SIZES = ("bnf-3205-2p5", "bnf-3205-5", "bnf-4010-5", "hiwin-63-10k5")
#: File with the 3D results, written by ``tests/nut_holding.py``.
FIXATION_FILE = "nut_holding.json"
THREE = "3D"
#: Number of bolts that fix a flange, and names of two fixations: of its whole annulus, or by bolts only.
BOLTS = 6
WHOLE, BOLTED = "flange, whole face", f"flange, {BOLTS} bolts"
#: Length of the centring fit, divided by the length of the nut between flange and free end.
FIT = 0.5


def scenes_by_nut_fixation(scene: Scene) -> dict[str, Scene]:
    """Return copies of a scene whose nut is fixed at different surfaces, by name of the surface; "left face" is first."""
    outer = scene.nut.outer_diameter
    thick = min(THICK * outer, 0.4 * scene.nut.length)
    seat = 0.5 * outer, 0.5 * RIM * outer
    flange = Flange(RIM * outer, thick, seat, centring=FIT * (scene.nut.length - thick))

    def fix_nut(fixed_surface: NutHeld, flange_of_nut: Flange | None = None) -> Scene:
        """Return a copy of the scene with the nut fixed at the surface ``fixed_surface``.

        ``flange_of_nut``: flange of the nut, or None.
        """
        nut, solid = replace(scene.nut, flange=flange_of_nut), replace(scene.solid, nut_held=fixed_surface)
        return replace(scene, nut=nut, solid=solid)

    return {
        "left face": fix_nut("left face"),
        "right face": fix_nut("right face"),
        "outer surface": fix_nut("outer surface"),
        WHOLE: fix_nut("flange face", flange),
        "flange, inner half of its face": fix_nut("flange face", replace(flange, seat=(seat[0], 0.5 * sum(seat)))),
        "flange, outer half of its face": fix_nut("flange face", replace(flange, seat=(0.5 * sum(seat), seat[1]))),
        BOLTED: fix_nut("flange face", replace(flange, bolts=BOLTS)),
        "flange and its centring fit": fix_nut("flange face", replace(flange, bonded=True)),
    }


@cache
def stored_fixation_results(store: Path) -> list[dict[str, Any]]:
    """Read the stored 3D results of screws whose nuts are fixed at different surfaces.

    Each item has the name of the scene, the fixation of the nut, mesh level, status, rigidity [N/m], and ball loads [N] by
    flank. ``store``: folder of the file `FIXATION_FILE`.
    """
    return list(json.loads((store / FIXATION_FILE).read_text(encoding="utf-8")))


def loads_of_stored_result(result: dict[str, Any]) -> Array:
    """Return the contact loads (n, 4) [N] of n balls on their four flanks, from one stored 3D result.

    The columns are the flanks SL, SR, NL and NR (screw or nut, left or right). Loads on flanks that the result does not
    contain are zero. ``result``: values of the stored result, by key as in the JSON file.
    """
    by_side = result["load"]
    return np.stack([by_side.get(side, np.zeros(len(next(iter(by_side.values()))))) for side in SIDES], axis=1)


def fixation_results_by_level(scene: str, fixation: str) -> dict[int, dict[str, Any]]:
    """Return the converged stored 3D results of a scene with one fixation of its nut, by mesh level from coarse to fine.

    ``scene``: name of the scene; ``fixation``: name of the fixation, a key of `scenes_by_nut_fixation`.
    """
    wanted = scene, fixation, "converged"
    runs = [x for x in stored_fixation_results(shipped_store()) if (x["scene"], x["held"], x["status"]) == wanted]
    return {x["level"]: x for x in sorted(runs, key=lambda x: int(x["level"]))}


def largest_mesh_uncertainty_percent(scene: Scene, loads: Mapping[int, Array]) -> float:
    """Return the largest mesh uncertainty of any contact load [% of the mean load], on the finest given mesh level.

    The uncertainty is the sum of the 95 % uncertainty by `compare.reference.estimate` (estimated from other scenes if only
    one mesh level is given) and the error of the 3D loads that the free end faces of the nut cause.

    Parameters
    ----------
    scene
        Ball screw and loads, which determine the error due to free faces.
    loads
        Contact loads (n, 4) [N] of n balls on four groove flanks in 3D, by mesh level.
    """
    level, mean = max(loads), mean_load(loads[max(loads)])
    by_mesh = mesh_uncertainty(loads, read_uncertainty_of_other_scenes(shipped_store())).uncertainties_of_loads(loads)
    bars = 0.01 * mean * by_mesh
    return float(error_percent((bars + load_error_near_faces(scene, loads[level], level)).max(), 0.0, mean))


def fixation_table_rows(cache: SceneResultCache, size: str) -> Iterator[Row]:
    """Yield table rows of a catalogue screw: largest contact load, life, rigidity, for each nut fixation and each model.

    The rows of the default model come first, then those of every stored mesh level of the 3D reference. The default model
    fixes the whole annulus of a flange, so it has no row for a flange fixed by bolts. ``cache``: gives the solved scenes;
    ``size``: name of the catalogue size, one of `SIZES`.
    """
    printed = printed_entry("external-thk", f"rigidity_{size}").value
    name = scene_name_of_catalogue_size(size)
    held = scenes_by_nut_fixation(cache.built_in_scene(name))
    found = {way: cache.solve_once(scene, DEFAULT) for way, scene in held.items() if way != BOLTED}
    in_3D = {way: fixation_results_by_level(name, way) for way in held}
    loads = {way: {k: loads_of_stored_result(x) for k, x in levels.items()} for way, levels in in_3D.items()}
    solved: list[tuple[str, str, Array, float, float | None]] = [
        (DEFAULT, way, x.load, axial_force(x) / float(motion_at(x, held[way].nut.position)[2]), None)
        for way, x in found.items()
        if x.converged
    ]
    for level in loads[next(iter(held))]:
        for way in (x for x in held if level in loads[x]):
            bar = largest_mesh_uncertainty_percent(held[way], {k: load for k, load in loads[way].items() if k <= level})
            rigidity = in_3D[way][level]["rigidity"]
            solved.append((f"{THREE}, level {level}", way, loads[way][level], rigidity, bar))
    first: dict[str, tuple[float, ...]] = {}
    for by, way, load, rigidity, mesh in solved:
        lasts = basic_rating_life(held[way], load)
        if lasts is None:
            continue
        values = float(load.max()), lasts.revolutions, 1e-6 * rigidity
        start = first.setdefault(by, values)
        changes = [float(error_percent(value, old)) for value, old in zip(values, start, strict=True)]
        model = by == DEFAULT
        error = load_error(load, loads[way][max(loads[way])]).max_percent if model and loads[way] else None
        yield {
            "scene": name,
            "model_or_level": by,
            "fixed_surface": way,
            "largest_load_g4": values[0],
            "load_change": changes[0],
            "expected_load_error": estimate_model_error(held[way], found[way]).loads if model else None,
            "largest_load_error": error,
            "mesh_uncertainty": mesh,
            "life": values[1],
            "life_change": changes[1],
            "axial_rigidity": values[2],
            "rigidity_change": changes[2],
            "catalogue_share": share_of_computed(printed, values[2]),
        }


def flange_bolts_sentence() -> str:
    """Return the sentence on how loads and rigidity change in 3D if only bolts fix the flange, not its whole annulus."""
    words = []
    for size in SIZES:
        scene = scene_name_of_catalogue_size(size)
        bolted, whole = fixation_results_by_level(scene, BOLTED), fixation_results_by_level(scene, WHOLE)
        levels = bolted.keys() & whole.keys()
        if levels:
            bolts, ring = bolted[max(levels)], whole[max(levels)]
            by_bolts, by_ring = loads_of_stored_result(bolts), loads_of_stored_result(ring)
            off = load_error(by_bolts, by_ring)
            largest = float(error_percent(by_bolts.max(), by_ring.max(), mean_load(by_ring)))
            stiff = float(error_percent(bolts["rigidity"], ring["rigidity"]))
            words.append(
                f"{scene} (level {max(levels)}): the largest load by {largest:+.2f} % of the mean load, any load by at "
                f"most {off.max_percent:.2f} % of it ({off.rms_percent:.2f} % RMS), the rigidity by {stiff:+.2f} %"
            )
    head = (
        f"{BOLTS} bolts (circles as wide as the annulus) that fix the flange instead of its whole face change, in {THREE}, "
    )
    return head + "; ".join(words) + "." if words else f"Flanges fixed by single bolts were not solved in {THREE}."


def mesh_uncertainty_sentence(rows: list[Row]) -> str:
    """Return the sentence on the mesh uncertainty of the loads in 3D, and on the change of results on a finer mesh.

    ``rows``: table rows of all catalogue sizes, fixations and models, from `fixation_table_rows`.
    """
    bars = [row["mesh_uncertainty"] for row in rows if row["mesh_uncertainty"] is not None]
    if not bars:
        return f"Nothing was solved in {THREE}."
    of = {(row["scene"], row["model_or_level"], row["fixed_surface"]): row for row in rows}
    moved: dict[str, list[float]] = {}
    for (scene, by, held), row in of.items():
        coarse = of.get((scene, f"{THREE}, level 1", held))
        if coarse is not None and by not in (DEFAULT, coarse["model_or_level"]):
            for column in ("load_change", "life_change", "rigidity_change"):
                moved.setdefault(column, []).append(abs(row[column] - coarse[column]))
            change = error_percent(row["axial_rigidity"], coarse["axial_rigidity"])
            moved.setdefault("rigidity", []).append(abs(float(change)))
    sentence = f"The meshes leave {min(bars):.2f} to {max(bars):.2f} % of the mean load uncertain (95 %)."
    if not moved:
        return sentence
    most = {column: f"{max(values):.2f}" for column, values in moved.items()}
    return (
        f"{sentence} Where two mesh levels were solved, the finer one alters the changes against the left face by at most "
        f"{most['load_change']} points (largest load), {most['life_change']} (life), {most['rigidity_change']} (rigidity), "
        f"the rigidity itself by {most['rigidity']} %."
    )


def column_range_in_words(rows: list[Row], column: str, fixation: str = "", form: str = "+.1f") -> str:
    """Return in words the smallest and largest value of a table column.

    ``rows``: table rows of the default model; ``column``: key of the column; ``fixation``: only fixations whose name
    begins with this text count, all if it is empty; ``form``: format of the numbers.
    """
    values = [row[column] for row in rows if row["fixed_surface"].startswith(fixation)]
    return f"{min(values):{form}} to {max(values):{form}}"


def flanged_nuts_sentence() -> str:
    """Return the sentence on the default model's errors for randomly drawn screws whose nuts are fixed at flanges.

    The errors are those of contact loads against the 3D reference.
    """
    nuts = [p for p in model_errors_on_random_screws() if p.model == DEFAULT and FLANGE in p.features]
    if not nuts:
        return "No random screw with a nut fixed at a flange was compared with the 3D reference."
    return (
        f"On {len(nuts)} random screws with nuts fixed at flanges, contact loads by the default model differ by at most "
        f"{max(p.percent for p in nuts):.2f} % of the mean load ({max(p.rms_percent for p in nuts):.2f} % RMS) from the 3D "
        "reference on mesh level 1."
    )


def fixation_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the effect of the nut's fixation on contact loads, life and rigidity.

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    step("nuts fixed at different surfaces")
    rows = [row for size in SIZES for row in fixation_table_rows(cache, size)]
    low = [row for row in rows if row["model_or_level"] == DEFAULT]
    left, whole, outer = (
        column_range_in_words(low, "catalogue_share", held, ".2f") for held in ("left", "flange, whole", "flange, outer")
    )
    bent = [row["catalogue_share"] for row in low if row["fixed_surface"].startswith("flange, outer")]
    conclusion = (
        "Fixing the nut at another surface than its left face changes the largest contact load by "
        f"{column_range_in_words(low, 'load_change')} %, the rating life by {column_range_in_words(low, 'life_change')} "
        f"% and the axial rigidity by {column_range_in_words(low, 'rigidity_change')} %."
    )
    text = (
        f"Catalogues print {left} of the rigidity computed with the nut fixed at its left face, "
        f"{whole} of that at the whole face of a flange, {outer} of that at the outer "
        f"half of this face, where the flange bends: the fixation "
        f"{'explains a part of' if min(bent) < 1.0 else 'can explain'} the difference.",
        mesh_uncertainty_sentence(rows),
        flange_bolts_sentence(),
        flanged_nuts_sentence(),
    )
    note = (
        f"Flange: at the left end, {RIM:g} of the nut's outer diameter in diameter and {THICK:g} in thickness, its annulus "
        "bonded to a rigid housing (assumed: no catalogue quoted here prints it). Rigidity: load over displacement of the "
        "screw's section at the nut's centre. Changes against the left face: of the same model, or in 3D."
    )
    title = "Catalogue screws: largest contact load, life and axial rigidity, for each surface at which the nut is fixed"
    table = Table.from_rows("nut-holding", title, rows, note)
    title = "Effect of the nut's fixation on contact loads, life and rigidity"
    return Section("holding", title, (Text(text), table), conclusion=conclusion)
