"""Section of the report: what the way in which a nut is held does to loads, life and rigidity, on catalogue sizes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rollbench.comparison.measure import error_percent
from rollbench.comparison.models.model_form import FLANGE, estimate, surveyed_points
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.scenes.like import RIM, THICK
from rollbench.comparison.sources.external.evidence.screws import scene_name
from rollbench.lowfi.rating.life import life
from rollbench.lowfi.rating.rigidity import axial_displacement, axial_force
from rollbench.meshes.parts import Flange, NutHeld, Scene
from rollbench.reports.records import Cell, Quantity, Section, Table, Text

#: Three sizes of two makers, by the names of their printed rigidities.
SIZES = ("bnf-3205-5", "bnf-4010-5", "hiwin-63-10k5")
#: Length of the centring fit over that of the nut beyond its flange.
FIT = 0.5
COLUMNS = (
    Quantity("scene", "scene", "", "s"),
    Quantity("held", "nut held at", "", "s"),
    Quantity("largest", "largest load", "N", "g4"),
    Quantity("load_change", "load over left face", "%", "+.2f"),
    Quantity("expected", "expected error of it", "% of mean", ".2f"),
    Quantity("life", "life L10", "10^6 rev", "g4"),
    Quantity("life_change", "life over left face", "%", "+.2f"),
    Quantity("rigidity", "rigidity", "N/um", "g4"),
    Quantity("rigidity_change", "rigidity over left face", "%", "+.2f"),
    Quantity("share", "catalogue over it", "", ".3f"),
)


def ways(scene: Scene) -> dict[str, Scene]:
    """The scene with its nut held in several ways, by name; its left face first."""
    outer = scene.nut.outer_diameter
    thick = min(THICK * outer, 0.4 * scene.nut.length)
    seat = 0.5 * outer, 0.5 * RIM * outer
    flange = Flange(RIM * outer, thick, seat, centring=FIT * (scene.nut.length - thick))

    def held(at: NutHeld, own: Flange | None = None) -> Scene:
        return replace(scene, nut=replace(scene.nut, flange=own), solid=replace(scene.solid, nut_held=at))

    return {
        "left face": held("left face"),
        "right face": held("right face"),
        "outer surface": held("outer surface"),
        "flange, whole face": held("flange face", flange),
        "flange, inner half of its face": held("flange face", replace(flange, seat=(seat[0], 0.5 * sum(seat)))),
        "flange, outer half of its face": held("flange face", replace(flange, seat=(0.5 * sum(seat), seat[1]))),
        "flange and its centring fit": held("flange face", replace(flange, bonded=True)),
    }


def rows_of(study: Study, size: str) -> list[dict[str, Cell]]:
    """One row for every way in which the nut of a catalogue size is held."""
    rows: list[dict[str, Cell]] = []
    printed = entry("external-thk", f"rigidity_{size}").value
    first: tuple[float, ...] = ()
    for name, scene in ways(study.scene(scene_name(size))).items():
        found = study.solve(scene, DEFAULT)
        lasts = life(scene, found.load)
        if not found.converged or lasts is None:
            continue
        rigidity = 1e-6 * axial_force(found) / axial_displacement(scene, found)
        values = float(found.load.max()), lasts.revolutions, rigidity
        first = first or values
        changes = [float(error_percent(value, start)) for value, start in zip(values, first, strict=True)]
        rows.append(
            {
                "scene": scene.name,
                "held": name,
                **dict(zip(("largest", "life", "rigidity"), values, strict=True)),
                **dict(zip(("load_change", "life_change", "rigidity_change"), changes, strict=True)),
                "expected": estimate(scene, found).percent,
                "share": None if printed is None else 1.0 + float(error_percent(printed, rigidity)) / 100.0,
            }
        )
    return rows


def between(rows: list[dict[str, Cell]], column: str, held: str = "", form: str = "+.1f") -> str:
    """Least and largest value of a column, of the ways that begin with ``held``, in words."""
    values = [float(row[column] or 0.0) for row in rows if str(row["held"]).startswith(held)]
    return f"{min(values):{form}} to {max(values):{form}}"


def flanged_words() -> str:
    """What was found of the default model on drawn nuts held by flanges."""
    own = [p for p in surveyed_points() if p.model == DEFAULT and FLANGE in p.features]
    if not own:
        return "No drawn nut held by a flange was compared with the 3D reference."
    return (
        f"On {len(own)} drawn nuts held by flanges the default model is off by at most "
        f"{max(p.percent for p in own):.2f} % of the mean load ({max(p.rms_percent for p in own):.2f} % RMS) from the 3D "
        "reference on level 1."
    )


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("ways of holding a nut")
    rows = [row for size in SIZES for row in rows_of(study, size)]
    shares = {held: between(rows, "share", held, ".2f") for held in ("left", "flange, whole", "flange, outer")}
    bent = [float(row["share"] or 0.0) for row in rows if str(row["held"]).startswith("flange, outer")]
    text = (
        f"The way of holding a nut moves its largest load by {between(rows, 'load_change')} %, its life by "
        f"{between(rows, 'life_change')} % and its rigidity by {between(rows, 'rigidity_change')} % against the left face. "
        f"Catalogues print {shares['left']} of the rigidity with the left face held, {shares['flange, whole']} with the "
        f"whole face of a flange, {shares['flange, outer']} where only the outer half of its face bears and the flange "
        f"bends: the holding is {'a part of' if min(bent, default=0.0) < 1.0 else 'enough for'} what makers count in.",
        flanged_words(),
    )
    note = (
        f"Flanges of {RIM:g} and {THICK:g} of the nut's outer diameter, in diameter and thickness, at the left end, bonded "
        "to a rigid housing all over the annulus: assumed, as no catalogue quoted here prints them. Rigidity is load over "
        "displacement of the screw's section at the nut's centre."
    )
    table = Table("nut-holding", "Three catalogue sizes, held in several ways", COLUMNS, rows, note)
    return Section("holding", "How the nut is held", (Text(text), table))
