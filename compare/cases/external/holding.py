"""Section on the effect of the nut's fixation on loads, life and rigidity, for catalogue sizes."""

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
from rollbench.compare.reference import grid_parts
from rollbench.compare.reference.grid_parts import error_near_faces
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.template import RIM, THICK
from rollbench.lowfi.rating.life import life
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Flange, NutHeld, Scene
from rollbench.reports.content import Cell, Quantity, Section, Table, Text

#: Sizes of two makers, by the names of their printed rigidities.
SIZES = ("bnf-3205-2p5", "bnf-3205-5", "bnf-4010-5", "hiwin-63-10k5")
#: File with the 3D results, written by ``tests/nut_holding.py``.
FILE = "nut_holding.json"
THREE = "3D"
#: Number of bolts instead of the whole annulus, and the names of both fixations.
BOLTS = 6
WHOLE, BOLTED = "flange, whole face", f"flange, {BOLTS} bolts"
#: Length of the centring fit over that of the nut beyond its flange.
FIT = 0.5
COLUMNS = (
    Quantity("scene", "scene", "", "s"),
    Quantity("by", "found by", "", "s"),
    Quantity("held", "nut held at", "", "s"),
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


def fixations(scene: Scene) -> dict[str, Scene]:
    """Return copies of the scene with its nut fixed at different surfaces, by name; its left face first."""
    outer = scene.nut.outer_diameter
    thick = min(THICK * outer, 0.4 * scene.nut.length)
    seat = 0.5 * outer, 0.5 * RIM * outer
    flange = Flange(RIM * outer, thick, seat, centring=FIT * (scene.nut.length - thick))

    def held(at: NutHeld, fitted: Flange | None = None) -> Scene:
        return replace(scene, nut=replace(scene.nut, flange=fitted), solid=replace(scene.solid, nut_held=at))

    return {
        "left face": held("left face"),
        "right face": held("right face"),
        "outer surface": held("outer surface"),
        WHOLE: held("flange face", flange),
        "flange, inner half of its face": held("flange face", replace(flange, seat=(seat[0], 0.5 * sum(seat)))),
        "flange, outer half of its face": held("flange face", replace(flange, seat=(0.5 * sum(seat), seat[1]))),
        BOLTED: held("flange face", replace(flange, bolts=BOLTS)),
        "flange and its centring fit": held("flange face", replace(flange, bonded=True)),
    }


@cache
def stored_results(store: Path) -> list[dict[str, Any]]:
    """Return the stored 3D results: scene, fixation, mesh level, status, rigidity [N/m], ball loads by flank [N]."""
    return list(json.loads((store / FILE).read_text(encoding="utf-8")))


def loads_of(row: dict[str, Any]) -> Array:
    """Return the contact loads ``(n, 4)`` [N] of a stored 3D result; zero on flanks that it does not contain."""
    by_side = row["load"]
    return np.stack([by_side.get(side, np.zeros(len(next(iter(by_side.values()))))) for side in SIDES], axis=1)


class Solved(NamedTuple):
    """Results for one fixation of the nut."""

    #: Model, or 3D reference.
    by: str
    #: Name of the fixation.
    way: str
    #: Contact loads, (n, 4) [N].
    load: Array
    #: Axial rigidity [N/m].
    rigidity: float
    #: Uncertainty of the loads by the mesh [% of the mean load].
    mesh: float | None = None


def by_level(scene: str, held: str) -> dict[int, dict[str, Any]]:
    """Return the converged stored runs of a scene with one fixation of its nut, by mesh level from coarse to fine."""
    runs = [
        x for x in stored_results(shipped_store()) if (x["scene"], x["held"], x["status"]) == (scene, held, "converged")
    ]
    return {x["level"]: x for x in sorted(runs, key=lambda x: int(x["level"]))}


def mesh_percent(scene: Scene, loads: Mapping[int, Array]) -> float:
    """Return the largest mesh uncertainty of any contact load [% of the mean load], on the finest given level.

    Sum of the 95 % uncertainty of `grid_parts` (from experience if there is one level) and the error near a free
    face.

    Parameters
    ----------
    scene
        The scene.
    loads
        Contact loads (n, 4) [N] by level.
    """
    level, mean = max(loads), mean_load(loads[max(loads)])
    bars = 0.01 * mean * grid_parts.parts(loads, grid_parts.read_experience(shipped_store())).bars(loads)
    return float(error_percent((bars + error_near_faces(scene, loads[level], level)).max(), 0.0, mean))


def rows_of(study: Study, size: str) -> list[dict[str, Cell]]:
    """Return the table rows of a catalogue size, one for each fixation of the nut and each model.

    The default model comes first (without bolts, as it fixes the whole annulus of a flange), then every stored level
    of the 3D reference.
    """
    printed = entry("external-thk", f"rigidity_{size}").value
    name = scene_name(size)
    held = fixations(study.scene(name))
    found = {way: study.solve(scene, DEFAULT) for way, scene in held.items() if way != BOLTED}
    in_3D = {way: by_level(name, way) for way in held}
    loads = {way: {k: loads_of(x) for k, x in levels.items()} for way, levels in in_3D.items()}
    solved = [
        Solved(DEFAULT, way, result.load, axial_force(result) / axial_displacement(held[way], result))
        for way, result in found.items()
        if result.converged
    ]
    for level in loads[next(iter(held))]:
        for way in (x for x in held if level in loads[x]):
            bar = mesh_percent(held[way], {k: load for k, load in loads[way].items() if k <= level})
            solved.append(Solved(f"{THREE}, level {level}", way, loads[way][level], in_3D[way][level]["rigidity"], bar))
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


def bolted_words() -> str:
    """Return a sentence on what fixing single bolts instead of the whole annulus changes in 3D."""
    words = []
    for size in SIZES:
        scene = scene_name(size)
        bolted, whole = by_level(scene, BOLTED), by_level(scene, WHOLE)
        levels = bolted.keys() & whole.keys()
        if levels:
            bolts, ring = bolted[max(levels)], whole[max(levels)]
            off, mean = load_error(loads_of(bolts), loads_of(ring)), mean_load(loads_of(ring))
            largest = float(error_percent(loads_of(bolts).max(), loads_of(ring).max(), mean))
            stiff = float(error_percent(bolts["rigidity"], ring["rigidity"]))
            words.append(
                f"{scene} (level {max(levels)}): the largest load by {largest:+.2f} % of the mean load, any load by at "
                f"most {off.max_percent:.2f} % of it ({off.rms_percent:.2f} % RMS), the rigidity by {stiff:+.2f} %"
            )
    head = f"{BOLTS} bolts instead of the whole annulus (held: circles as wide as it) change in {THREE} "
    return head + "; ".join(words) + "." if words else f"Single bolts were not solved in {THREE}."


def mesh_words(rows: list[dict[str, Cell]]) -> str:
    """Return a sentence on the mesh uncertainty of the loads, and on how much a finer level changes the table."""
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
    """Return as text the range of a column over the default model's rows whose fixation begins with ``held``."""
    values = [float(row[column] or 0.0) for row in rows if row["by"] == DEFAULT and str(row["held"]).startswith(held)]
    return f"{min(values):{form}} to {max(values):{form}}"


def flanged_words() -> str:
    """Return a sentence on the errors of the default model for drawn nuts fixed at flanges."""
    nuts = [p for p in points_of_drawn_screws() if p.model == DEFAULT and FLANGE in p.features]
    if not nuts:
        return "No drawn nut held by a flange was compared with the 3D reference."
    return (
        f"On {len(nuts)} drawn nuts held by flanges the default model is off by at most "
        f"{max(p.percent for p in nuts):.2f} % of the mean load ({max(p.rms_percent for p in nuts):.2f} % RMS) from the 3D "
        "reference on level 1."
    )


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("ways of holding a nut")
    rows = [row for size in SIZES for row in rows_of(study, size)]
    shares = {held: range_text(rows, "share", held, ".2f") for held in ("left", "flange, whole", "flange, outer")}
    bent = [float(x["share"] or 0.0) for x in rows if x["by"] == DEFAULT and str(x["held"]).startswith("flange, outer")]
    conclusion = (
        f"The way of holding a nut moves its largest load by {range_text(rows, 'load_change')} %, its life by "
        f"{range_text(rows, 'life_change')} % and its rigidity by {range_text(rows, 'rigidity_change')} % against "
        "the left face."
    )
    text = (
        f"Catalogues print {shares['left']} of the rigidity with the left face held, {shares['flange, whole']} with the "
        f"whole face of a flange, {shares['flange, outer']} where only the outer half of its face bears and the flange "
        f"bends: the holding is {'a part of' if min(bent, default=0.0) < 1.0 else 'enough for'} what makers count in.",
        mesh_words(rows),
        bolted_words(),
        flanged_words(),
    )
    note = (
        f"Flanges of {RIM:g} and {THICK:g} of the nut's outer diameter, in diameter and thickness, at the left end, bonded "
        "to a rigid housing all over the annulus: assumed, as no catalogue quoted here prints them. Rigidity is load over "
        "displacement of the screw's section at the nut's centre. Model and 3D are each held against their own left face."
    )
    table = Table(
        "nut-holding",
        "Largest load, life and rigidity of catalogue screws by the face at which the nut is fixed",
        COLUMNS,
        rows,
        note,
    )
    return Section("holding", "How the nut is held", (Text(text), table), conclusion=conclusion)
