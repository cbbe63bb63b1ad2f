"""Nuts of makers' catalogues as scenes, with balls that are not counted from any rating: C, C_0 and K over the maker's.

The scene of each nut is that of ``rollbench new --like NAME``: what is printed, and for the rest the rules of that command.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from rollbench.compare.cases.makers import nuts
from rollbench.compare.scenes import makers, scene_file
from rollbench.compare.scenes.catalogue_part import scene_text_of_nut
from rollbench.lowfi.rating import rigidity
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Errors, Scene
from rollbench.reports.content import Figure, Panel, Row, Series, Table

#: Ratios of computed to printed values between which they are not named.
USUAL = (0.7, 1.4)

#: Quantities that are compared, and what they are.
QUANTITIES = {"C": "dynamic load rating", "C0": "static load rating", "K": "axial rigidity, 0.8 of the computed one"}


@dataclass(frozen=True)
class CatalogueRatios:
    """Computed over printed values of one nut: C, C_0 and K; None: not printed, or a misprint by the table.

    ``group``: maker, and type of the nut where he rates types by different rules; ``name``: the nut's name.
    """

    group: str
    name: str
    ratios: dict[str, float | None]


def scene_of_part(part: makers.CataloguePart) -> Scene:
    """Return the scene of a catalogue nut without errors and preload; of a double nut, one of the nuts."""
    found = scene_file.parse_scene(scene_text_of_nut(part), part.label)
    one = found.sets[0].parts if isinstance(found, Assembly) else found
    assert isinstance(one, Scene)
    return replace(one, errors=Errors())


def displacement(scene: Scene, force: float) -> float:
    """Return the axial displacement [m] of a nut without preload, by contacts and tubes; ``force``: axial load [N]."""
    bodies = rigidity.axial_compliance_of_bodies(scene) or 0.0
    return rigidity.displacement_by_contacts_only(scene, force) + force * bodies


def computed_rigidity(part: makers.CataloguePart, scene: Scene, dynamic: float) -> float | None:
    """Return the rigidity [N/um] of a nut under the conditions of its maker, times 0.8 as makers advise.

    Without preload it is the secant under 0.3 C; THK's preloaded nuts: from 0.1 C to 0.3 C; Rexroth's: the secant from
    the highest printed preload to the load at which one of two nuts is free. None if Rexroth's table has no such nut.
    ``dynamic``: the maker's C [N].
    """
    load = nuts.LOADED * dynamic
    if part.maker == "Rexroth":
        share = max(makers.printed_rigidities_of_preloads(part), default=(0.0, 0.0))[0]
        if not share:
            return None
        load, moved = nuts.LIFT * 0.01 * share * dynamic, displacement(scene, 0.01 * share * dynamic)
    else:
        preloaded = part.type in part.table.header.get("preloaded", "-").split(", ")
        start = displacement(scene, nuts.PRELOADED * dynamic) if preloaded else 0.0
        moved = displacement(scene, load) - start
    return 1e-6 * rigidity.PRACTICE * load / moved


def ratios_of_part(part: makers.CataloguePart) -> CatalogueRatios:
    """Return computed over printed C, C_0 and K of a nut."""
    scene, load = scene_of_part(part), part.table.unit_factor("load_unit")
    printed = {"C": part.number("C", load), "C0": part.number("C0", load), "K": makers.rigidity_of_nut(part)}
    dynamic = printed["C"]
    assert dynamic is not None
    computed = {"C": dynamic_rating(scene), "C0": static_rating(scene), "K": computed_rigidity(part, scene, dynamic)}
    wrong = {"C": part.is_misprint("C"), "C0": part.is_misprint("C0"), "K": part.is_misprint("rigidity")}
    wrong["K"] |= wrong["C"]  # under a part of C
    ratios: dict[str, float | None] = {}
    for key, value in computed.items():
        given = printed[key]
        ratios[key] = value / given if value and given and not wrong[key] else None
    maker = part.maker
    group = nuts.maker_and_rated_nut_type(part.table, part.row) if maker in ("HIWIN", "THK") else maker
    return CatalogueRatios(group, part.label.removeprefix(f"{maker} "), ratios)


@cache
def ratios_of_all_nuts() -> tuple[CatalogueRatios, ...]:
    """Return computed over printed C, C_0 and K of every nut in the makers' tables."""
    return tuple(ratios_of_part(part) for part in makers.nuts_in_catalogues())


def unusual_ratios(found: Sequence[CatalogueRatios]) -> str:
    """Return the names of the nuts with a ratio outside `USUAL`, each with these ratios.

    A quantity of which every ratio is outside is named once, with its range.
    """
    words, named = [], []
    for key in QUANTITIES:
        values = [x for one in found if (x := one.ratios[key]) is not None]
        if values and all(map(is_unusual, values)):
            words.append(f"{key} of all, {min(values):.2f} to {max(values):.2f}")
        else:
            named.append(key)
    for one in found:
        beyond = [f"{key} {x:.2f}" for key in named if (x := one.ratios[key]) is not None and is_unusual(x)]
        if beyond:
            words.append(f"{one.name}: {', '.join(beyond)}")
    return "; ".join(words)


def is_unusual(ratio: float) -> bool:
    """Return whether the ratio of a computed to a printed value is outside `USUAL`."""
    return not USUAL[0] <= ratio <= USUAL[1]


def catalogue_text() -> str:
    """Return the paragraph on how many computed C, C_0 and K of catalogue nuts are near what their makers print."""
    found, parts = ratios_of_all_nuts(), []
    for key in QUANTITIES:
        values = [x for one in found if (x := one.ratios[key]) is not None]
        inside = len(values) - sum(map(is_unusual, values))
        parts.append(f"{inside} of {len(values)} {key.replace('C0', 'C_0')} (median {np.median(values):.2f})")
    return (
        f"From the catalogue names of {len(found)} nuts, without counting balls from a rating, computed over printed is "
        f"within {USUAL[0]:g} to {USUAL[1]:g} for {', '.join(parts)}. THK prints no balls: they are assumed from "
        "pitch and root diameter and lead. Rexroth's C_0 and rigidity have other definitions."
    )


def _ratios_by_group() -> dict[str, list[CatalogueRatios]]:
    """Return the ratios of all nuts by maker, and by type of nut where he rates types by different rules."""
    groups: dict[str, list[CatalogueRatios]] = {}
    for one in ratios_of_all_nuts():
        groups.setdefault(one.group, []).append(one)
    return groups


def catalogue_ratios_figure() -> Figure:
    """Draw computed over printed C, C_0 and K of every nut, with a line of points for each maker."""
    groups, series = _ratios_by_group(), []
    for key, shift in zip(QUANTITIES, (-0.22, 0.0, 0.22), strict=True):
        each = [(one.ratios[key], row) for row, found in enumerate(groups.values(), 1) for one in found]
        at = [(x, row + shift) for x, row in each if x is not None]
        series.append(Series(key, [x for x, _ in at], [y for _, y in at], "markers"))
    ends = [0.4, len(groups) + 0.6]
    series += [Series("", [limit, limit], ends, "line", pale=True) for limit in USUAL]
    names = [f"{group} ({len(found)})" for group, found in groups.items()]
    panel = Panel("", "computed over printed", "", tuple(series), ordinate_names=names)
    title = "C, C0 and rigidity K of all nuts in makers' catalogues, computed from new --like over printed"
    caption = f"Each point is a nut, in brackets the number of nuts. Lines: {USUAL[0]:g} and {USUAL[1]:g}."
    return Figure("outside-nuts", title, (panel,), caption, 1, size=(9.0, 5.0))


def catalogue_ratios_table() -> Table:
    """Return the table of computed over printed C, C_0 and K: median and range by maker, and nuts outside `USUAL`."""
    rows: list[Row] = []
    for group, found in _ratios_by_group().items():
        row: Row = {"maker": group, "nuts": len(found)}
        for key, what in QUANTITIES.items():
            values = [x for one in found if (x := one.ratios[key]) is not None]
            row["computed_over_printed", what, key] = (
                f"{np.median(values):.2f} ({min(values):.2f} to {max(values):.2f})" if values else None
            )
        row["unusual_nuts", f"{USUAL[0]:g} to {USUAL[1]:g}"] = unusual_ratios(found)
        rows.append(row)
    note = (
        "Scenes as rollbench new --like NAME writes them, with 0.9 of the turns filled with balls: no ball is counted from "
        "a rating. K: contacts and tubes under 0.3 of the maker's C (THK's preloaded nuts: preload 0.1 C; Rexroth: the "
        "highest printed preload), times 0.8. Misprints by the makers' tables are left out; LIMON prints no rigidity."
    )
    title = "C, C0 and rigidity of all nuts in makers' catalogues, computed from new --like over printed"
    return Table.from_rows("outside-catalogue", title, rows, note)
