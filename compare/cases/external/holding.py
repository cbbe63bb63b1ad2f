"""Report section: contact loads, life and rigidity of catalogue screws by the surface at which the nut is fixed."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.cases.external.evidence import scene_name
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.model_form import FLANGE, estimate, points_of_drawn_screws
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.printed import entry
from rollbench.compare.reference.estimate import error_near_faces, parts, read_experience
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.template import RIM, THICK
from rollbench.lowfi.rating.life import life
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Flange, NutHeld, Scene
from rollbench.reports.content import Cell, Quantity, Section, Table, Text

#: Catalogue sizes of two makers, by the keys of their printed rigidities.
SIZES = ("bnf-3205-2p5", "bnf-3205-5", "bnf-4010-5", "hiwin-63-10k5")
#: File with the 3D results, written by ``tests/nut_holding.py``.
FILE = "nut_holding.json"
THREE = "3D"
#: Number of bolts that fix a flange, and names of both ways of fixing it: its whole annulus, or bolts only.
BOLTS = 6
WHOLE, BOLTED = "flange, whole face", f"flange, {BOLTS} bolts"
#: Length of the centring fit over the length of the nut beyond its flange.
FIT = 0.5
COLUMNS = (
    Quantity("scene", "scene", "", "s"),
    Quantity("by", "computed by", "", "s"),
    Quantity("held", "nut fixed at", "", "s"),
    Quantity("largest", "largest load", "N", "g4"),
    Quantity("load_change", "load over left face", "%", "+.2f"),
    Quantity("expected", "expected error of it", "% of mean", ".2f"),
    Quantity("off", f"largest error against {THREE}", "% of mean", ".2f"),
    Quantity("mesh", f"uncertainty of {THREE} by its mesh", "% of mean", ".2f"),
    Quantity("life", "life L10", "10^6 rev", "g4"),
    Quantity("life_change", "life over left face", "%", "+.2f"),
    Quantity("rigidity", "rigidity", "N/um", "g4"),
    Quantity("rigidity_change", "rigidity over left face", "%", "+.2f"),
    Quantity("share", "catalogue over it", "", ".3f"),
)


def scenes_by_fixation(scene: Scene) -> dict[str, Scene]:
    """Return copies of a scene whose nut is fixed at different surfaces, by name of the surface; "left face" is first."""
    outer = scene.nut.outer_diameter
    thick = min(THICK * outer, 0.4 * scene.nut.length)
    seat = 0.5 * outer, 0.5 * RIM * outer
    flange = Flange(RIM * outer, thick, seat, centring=FIT * (scene.nut.length - thick))

    def fix_nut(at: NutHeld, fitted: Flange | None = None) -> Scene:
        """Return a copy of the scene with the nut fixed at the surface ``at``; ``fitted``: flange of the nut, or None."""
        return replace(scene, nut=replace(scene.nut, flange=fitted), solid=replace(scene.solid, nut_held=at))

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
def stored_results(store: Path) -> list[dict[str, Any]]:
    """Read the stored 3D results: scene, fixation, mesh level, status, rigidity [N/m], ball loads by flank [N]."""
    return list(json.loads((store / FILE).read_text(encoding="utf-8")))


def stored_contact_loads(row: dict[str, Any]) -> Array:
    """Return the contact loads (n, 4) [N] of n balls from a stored 3D result.

    Loads on flanks that the result does not contain are zero; ``row``: the result, by key of the JSON file.
    """
    by_side = row["load"]
    return np.stack([by_side.get(side, np.zeros(len(next(iter(by_side.values()))))) for side in SIDES], axis=1)


class FixationResult(NamedTuple):
    """Contact loads and rigidity of a screw by one model, for one fixation of its nut."""

    #: Name of the model, or 3D reference with its mesh level.
    by: str
    #: Name of the fixation.
    way: str
    #: Contact loads, (n, 4) [N].
    load: Array
    #: Axial rigidity [N/m].
    rigidity: float
    #: Uncertainty of the loads by the mesh [% of the mean load].
    mesh: float | None = None


def runs_by_level(scene: str, held: str) -> dict[int, dict[str, Any]]:
    """Return the converged stored 3D results of a scene with one fixation of its nut, by mesh level from coarse to fine."""
    runs = [
        x for x in stored_results(shipped_store()) if (x["scene"], x["held"], x["status"]) == (scene, held, "converged")
    ]
    return {x["level"]: x for x in sorted(runs, key=lambda x: int(x["level"]))}


def mesh_percent(scene: Scene, loads: Mapping[int, Array]) -> float:
    """Return the largest mesh uncertainty of any contact load [% of the mean load], on the finest given level.

    It is the sum of the 95 % uncertainty by `compare.reference.estimate` (from experience if there is one level) and of the
    error near a free face.

    Parameters
    ----------
    scene
        The scene.
    loads
        Contact loads (n, 4) [N] of n balls in 3D, by mesh level.
    """
    level, mean = max(loads), mean_load(loads[max(loads)])
    bars = 0.01 * mean * parts(loads, read_experience(shipped_store())).bars(loads)
    return float(error_percent((bars + error_near_faces(scene, loads[level], level)).max(), 0.0, mean))


def fixation_rows(study: Study, size: str) -> list[dict[str, Cell]]:
    """Return the table rows of a catalogue screw: largest load, life and rigidity for each fixation and model.

    ``size``: name of the catalogue size, one of `SIZES`. The default model comes first (without bolts, as it fixes the
    whole annulus of a flange), then every stored level of the 3D reference.
    """
    printed = entry("external-thk", f"rigidity_{size}").value
    name = scene_name(size)
    held = scenes_by_fixation(study.scene(name))
    found = {way: study.solve(scene, DEFAULT) for way, scene in held.items() if way != BOLTED}
    in_3D = {way: runs_by_level(name, way) for way in held}
    loads = {way: {k: stored_contact_loads(x) for k, x in levels.items()} for way, levels in in_3D.items()}
    solved = [
        FixationResult(DEFAULT, way, result.load, axial_force(result) / axial_displacement(held[way], result))
        for way, result in found.items()
        if result.converged
    ]
    for level in loads[next(iter(held))]:
        for way in (x for x in held if level in loads[x]):
            bar = mesh_percent(held[way], {k: load for k, load in loads[way].items() if k <= level})
            solved.append(
                FixationResult(f"{THREE}, level {level}", way, loads[way][level], in_3D[way][level]["rigidity"], bar)
            )
    rows: list[dict[str, Cell]] = []
    first: dict[str, tuple[float, ...]] = {}
    for by, way, load, rigidity, mesh in solved:
        lasts = life(held[way], load)
        if lasts is None:
            continue
        values = float(load.max()), lasts.revolutions, 1e-6 * rigidity
        start = first.setdefault(by, values)
        changes = [float(error_percent(value, old)) for value, old in zip(values, start, strict=True)]
        model = by == DEFAULT
        rows.append(
            {
                "scene": name,
                "by": by,
                "held": way,
                **dict(zip(("largest", "life", "rigidity"), values, strict=True)),
                **dict(zip(("load_change", "life_change", "rigidity_change"), changes, strict=True)),
                "expected": estimate(held[way], found[way]).percent if model else None,
                "off": load_error(load, loads[way][max(loads[way])]).max_percent if model and loads[way] else None,
                "mesh": mesh,
                "share": None if printed is None else 1.0 + float(error_percent(printed, values[2])) / 100.0,
            }
        )
    return rows


def bolts_sentence() -> str:
    """Return the sentence on the change of loads and rigidity in 3D where bolts fix the flange, not its whole annulus."""
    words = []
    for size in SIZES:
        scene = scene_name(size)
        bolted, whole = runs_by_level(scene, BOLTED), runs_by_level(scene, WHOLE)
        levels = bolted.keys() & whole.keys()
        if levels:
            bolts, ring = bolted[max(levels)], whole[max(levels)]
            off, mean = (
                load_error(stored_contact_loads(bolts), stored_contact_loads(ring)),
                mean_load(stored_contact_loads(ring)),
            )
            largest = float(error_percent(stored_contact_loads(bolts).max(), stored_contact_loads(ring).max(), mean))
            stiff = float(error_percent(bolts["rigidity"], ring["rigidity"]))
            words.append(
                f"{scene} (level {max(levels)}): the largest load by {largest:+.2f} % of the mean load, any load by at "
                f"most {off.max_percent:.2f} % of it ({off.rms_percent:.2f} % RMS), the rigidity by {stiff:+.2f} %"
            )
    head = f"{BOLTS} bolts instead of the whole annulus (held: circles as wide as it) change in {THREE} "
    return head + "; ".join(words) + "." if words else f"Single bolts were not solved in {THREE}."


def mesh_uncertainty_sentence(rows: list[dict[str, Cell]]) -> str:
    """Return the sentence on the mesh uncertainty of the 3D loads, and on the change by a finer mesh level.

    ``rows``: rows of the table of all sizes, fixations and models.
    """
    bars = [float(row["mesh"] or 0.0) for row in rows if row["mesh"] is not None]
    if not bars:
        return f"Nothing was solved in {THREE}."
    of = {(row["scene"], row["by"], row["held"]): row for row in rows}
    moved: dict[str, list[float]] = {}
    for (scene, by, held), row in of.items():
        coarse = of.get((scene, f"{THREE}, level 1", held))
        if coarse is not None and by not in (DEFAULT, coarse["by"]):
            for column in ("load_change", "life_change", "rigidity_change"):
                moved.setdefault(column, []).append(abs(float(row[column] or 0.0) - float(coarse[column] or 0.0)))
            moved.setdefault("rigidity", []).append(
                abs(float(error_percent(float(row["rigidity"] or 0.0), float(coarse["rigidity"] or 1.0))))
            )
    sentence = f"The meshes leave {min(bars):.2f} to {max(bars):.2f} % of the mean load uncertain (95 %)."
    if not moved:
        return sentence
    most = {column: f"{max(values):.2f}" for column, values in moved.items()}
    return (
        f"{sentence} Where two levels were solved, the finer one moves the changes over the left face by at most "
        f"{most['load_change']} points (largest load), {most['life_change']} (life), {most['rigidity_change']} (rigidity), "
        f"the rigidity itself by {most['rigidity']} %."
    )


def range_text(rows: list[dict[str, Cell]], column: str, held: str = "", form: str = "+.1f") -> str:
    """Return in words the range of a table column over the rows of the default model.

    ``held``: how the names of the fixations begin that count; ``form``: format of the numbers.
    """
    values = [float(row[column] or 0.0) for row in rows if row["by"] == DEFAULT and str(row["held"]).startswith(held)]
    return f"{min(values):{form}} to {max(values):{form}}"


def flanged_nuts_sentence() -> str:
    """Return the sentence on the default model's errors for randomly drawn screws whose nuts are fixed at flanges."""
    nuts = [p for p in points_of_drawn_screws() if p.model == DEFAULT and FLANGE in p.features]
    if not nuts:
        return "No drawn nut fixed at a flange was compared with the 3D reference."
    return (
        f"On {len(nuts)} drawn nuts fixed at flanges the default model is off by at most "
        f"{max(p.percent for p in nuts):.2f} % of the mean load ({max(p.rms_percent for p in nuts):.2f} % RMS) from the 3D "
        "reference on level 1."
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the report's section on the effect of the nut's fixation on loads, life and rigidity."""
    step("ways of holding a nut")
    rows = [row for size in SIZES for row in fixation_rows(study, size)]
    shares = {held: range_text(rows, "share", held, ".2f") for held in ("left", "flange, whole", "flange, outer")}
    bent = [float(x["share"] or 0.0) for x in rows if x["by"] == DEFAULT and str(x["held"]).startswith("flange, outer")]
    conclusion = (
        f"The surface at which a nut is fixed changes its largest load by {range_text(rows, 'load_change')} %, its life by "
        f"{range_text(rows, 'life_change')} % and its rigidity by {range_text(rows, 'rigidity_change')} % against "
        "the left face."
    )
    text = (
        f"Catalogues print {shares['left']} of the rigidity with the left face held, {shares['flange, whole']} with the "
        f"whole face of a flange, {shares['flange, outer']} where only the outer half of its face bears and the flange "
        f"bends: the holding is {'a part of' if min(bent, default=0.0) < 1.0 else 'enough for'} what makers count in.",
        mesh_uncertainty_sentence(rows),
        bolts_sentence(),
        flanged_nuts_sentence(),
    )
    note = (
        f"Flanges of {RIM:g} and {THICK:g} of the nut's outer diameter, in diameter and thickness, at the left end, bonded "
        "to a rigid housing all over the annulus: assumed, as no catalogue quoted here prints them. Rigidity is load over "
        "displacement of the screw's section at the nut's centre. Changes of the model and of 3D refer to "
        "their own results with the left face fixed."
    )
    table = Table(
        "nut-holding",
        "Largest load, life and rigidity of catalogue screws by the face at which the nut is fixed",
        COLUMNS,
        rows,
        note,
    )
    return Section(
        "holding",
        "Effect of the nut's fixation on contact loads, life and rigidity",
        (Text(text), table),
        conclusion=conclusion,
    )
