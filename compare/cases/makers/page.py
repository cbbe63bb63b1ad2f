"""Report page that compares computed values with makers' tables, measurements and other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from rollbench.compare.cases.makers import bearings, from_catalogue, nuts, outside
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.scenes.makers import read_maker_tables
from rollbench.lowfi.rating.rigidity import PRACTICE
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

TITLE = "Computed values compared with makers' tables, measurements and other programs"
#: Order of the quantities in tables; other quantities follow them.
ORDER = ("contact load", "displacement", "pressure", "torque", "rigidity", "rating", "preload")
COMPARISONS = (
    bearings.compare_nsk_bearing_sets,
    bearings.compare_nsk_ball_bearings,
    bearings.compare_snfa_load_ratings,
    bearings.compare_snfa_pair_rigidities,
    nuts.compare_nut_ratings,
    nuts.compare_nut_rigidity,
    nuts.compare_preloaded_nuts,
    nuts.compare_rexroth_drag_torques,
    nuts.compare_measured_drag_torques,
)


def all_published_values(cache: SceneResultCache) -> tuple[outside.PublishedValue, ...]:
    """Return all published values with their computed values, sorted by quantity; ``cache``: caches the result."""
    return cache.compute_once(_all_published_values)


def _all_published_values(cache: SceneResultCache) -> tuple[outside.PublishedValue, ...]:
    """Compute all values that are compared with published ones, sorted by quantity; ``cache``: gives the solved scenes."""
    found = [
        *outside.published_values_of_external_case(cache),
        *outside.contact_loads_by_calculix(cache),
        *(x for law in COMPARISONS for x in law()),
    ]
    rank = {name: k for k, name in enumerate(ORDER)}
    return tuple(sorted(found, key=lambda x: rank.get(x.quantity, len(rank))))


def first_page(cache: SceneResultCache) -> dict[str, Row]:
    """Return table cells for the report's first page: number, bias [%] and scatter [%] of the errors, by quantity.

    The errors are those of computed against published values. ``cache``: gives solved scenes and stored 3D references.
    """
    return outside.statistics_cells_by_quantity(all_published_values(cache))


def _error_statistics_of_quantity(
    found: Sequence[outside.PublishedValue], quantity: str, model_prefix: str = "", maker_prefix: str = ""
) -> dict[str, Any]:
    """Return bias and scatter of the errors of one quantity, by column; at least one value must be judged.

    ``found``: published values with the computed ones; ``quantity``: name of the quantity, such as "rigidity";
    ``model_prefix``, ``maker_prefix``: first characters of the names of the models and makers that count; empty: all.
    """
    of_law = [x for x in found if x.law.startswith(model_prefix) and x.maker.startswith(maker_prefix)]
    result = outside.error_statistics([x for x in of_law if x.quantity == quantity])
    assert result is not None
    return result


def _clearance_errors_um(found: Sequence[outside.PublishedValue]) -> Array:
    """Return the differences [um] of computed from printed axial clearances of preloaded bearings in ``found``."""
    printed = (x for x in found if not x.left and x.quantity == "displacement" and x.unit == "um" and x.scale)
    return np.array([x.computed.value - x.value for x in printed])


def band_and_errors_conclusion(found: Sequence[outside.PublishedValue]) -> str:
    """Return the page's conclusion: number of published values in their computed ranges, errors of some of them.

    The errors are those of bearing values for which no input had to be assumed.
    ``found``: all published values with the computed ones. The range (band) of a computed value covers rounded and
    unprinted inputs.
    """
    judged = [x for x in found if not x.left]
    clear = _error_statistics_of_quantity(found, "displacement", "bearing whose angle turns")
    off = _clearance_errors_um(found)
    quantities = "preload", "rigidity", "torque"
    sets = [_error_statistics_of_quantity(found, quantity, "sets and preloads", "NSK") for quantity in quantities]
    within = sum(x.verdict == "in the band" for x in judged)
    each = ", ".join(f"{s['bias_f1']:+.1f} and {s['scatter_f1']:.1f} %" for s in sets)
    return (
        f"Of {len(judged)} values published by makers, from measurements and by other programs, {within} lie within "
        "their computed ranges, which cover rounded and unprinted inputs. Where no input is unknown, both agree: bias "
        f"and scatter of preload, rigidity and starting torque of NSK's sets are {each}, and {clear['published_values']} "
        f"axial clearances agree to {np.sqrt((off**2).mean()):.2f} um RMS."
    )


def clearances_text(found: Sequence[outside.PublishedValue]) -> str:
    """Return the paragraph on NSK's printed clearances and rigidities: they agree if the contact angle changes under load.

    ``found``: all published values with the computed ones.
    """
    stiff = _error_statistics_of_quantity(found, "rigidity", "bearing whose angle turns")
    off = _clearance_errors_um(found)
    return (
        "NSK calls its axial clearances measured, but they follow from a contact angle that changes under load: "
        "with balls from the ratings and the conformity from one rigidity of each bearing, "
        f"{int((np.abs(off) <= 1.0).sum())} of {off.size} clearances are computed within 1 um. At other preloads, computed "
        f"rigidities have bias {stiff['bias_f1']:+.1f} and scatter {stiff['scatter_f1']:.1f} %."
    )


def nut_rigidity_text(found: Sequence[outside.PublishedValue]) -> str:
    """Return the paragraph on why makers print lower rigidities of nuts than are computed.

    ``found``: all published values with the computed ones.
    """
    judged = [x for x in found if not x.left and x.practice is not None]
    most = [x for x in judged if x.maker != "Rexroth"]
    rest = outside.group_by_fields(most, "maker")
    after = {key: [float(error_percent(x.practice or 0.0, x.value)) for x in one] for key, one in rest.items()}
    means = [float(np.mean(errors)) for errors in after.values()]
    close = sum(abs(error) <= 10.0 for errors in after.values() for error in errors)
    bare = outside.error_statistics(most)
    rex = outside.error_statistics([x for x in judged if x.maker == "Rexroth"])
    assert bare is not None
    assert rex is not None
    return (
        f"Printed rigidities of nuts are lower than computed because makers print about {100.0 * PRACTICE:g} % of the "
        "computed value. With the number of loaded balls inferred from the maker's own C_0, contacts and tubes are "
        f"{bare['bias_f1']:+.0f} % from what is printed, {100.0 * PRACTICE:g} % of them {min(means):+.0f} to "
        f"{max(means):+.0f} % by maker, and {close} of {len(most)} nuts lie within 10 %. Rexroth's rigidities are not "
        f"reproduced ({rex['bias_f1']:+.0f} %): printed values are 0.43 times the computed ones at every size and "
        "preload. The origin of this factor stays open (ISO 3408-4's factor of accuracy is named, but its value could not "
        "be read); the growth of Rexroth's values with preload does come out."
    )


def loaded_balls_text(found: Sequence[outside.PublishedValue]) -> str:
    """Return the paragraph on the number of loaded balls in a nut that makers' ratings C and C_0 imply.

    ``found``: all published values with the computed ones.
    """
    shares = dict[str, list[tuple[float, float]]]()
    for source in read_maker_tables("nuts-"):
        for row in source.rows:
            if row["ball_mm"] and not source.is_listed_as_misprint(row["nut"]) and source.header["maker"] != "Rexroth":
                nut, unit = nuts.nut_of_catalogue_row(source, row), source.unit_factor("load_unit")
                ratings = nuts.nut_load_ratings(nut, nuts.CONFORMITY, 1.0)
                printed = [source.parse_number(row[key]) * unit / x for key, x in zip(("C", "C0"), ratings, strict=True)]
                shares.setdefault(nuts.maker_and_rated_nut_type(source, row), []).append((printed[0] ** 1.5, printed[1]))
    words = ", ".join(
        f"{name} {np.median([x for _, x in pairs]):.2f} ({np.median([x for x, _ in pairs]):.2f} by C)"
        for name, pairs in shares.items()
    )
    rex = [x for x in found if x.maker == "Rexroth" and x.quantity == "rating"]
    ratios = ([x.computed.value / x.value for x in rex if x.part.endswith(f" {key}")] for key in ("C", "C0"))
    high = [float(np.median(of_rating)) for of_rating in ratios]
    return (
        "C and C_0 of a nut, two different formulas, give the same fraction of the balls that touch: "
        f"{words}. A nut with one deflector per turn is rated with two thirds of a turn. Rexroth's C is that "
        f"of full turns (computed/printed {high[0]:.2f}), its C_0 is not ({high[1]:.2f}): another definition. "
        "SNFA's ratings are ISO's times constants of the series."
    )


def drag_torque_text(found: Sequence[outside.PublishedValue]) -> str:
    """Return the paragraph on makers' formulas for drag torque, compared with sliding balls and with measured screws.

    ``found``: all published values with the computed ones.
    """
    columns = drag_torque_table().columns
    exponents = [nuts.fit_power_exponent(values, columns["lead"]) for values in columns.values()]
    sliding, theirs = exponents[1:3], exponents[5:]
    named = ", ".join(f"{name.split(':')[0]} {x:.2f}" for name, x in zip(nuts.FORMULAS, theirs, strict=True))
    shares = [nuts.SHARE, 2.0 * nuts.SHARE]
    nut, drag = nuts.nut_for_drag_comparison(0.01), nuts.drag_torque_of_ball
    over = [
        nuts.fit_power_exponent([drag(nut, x, nuts.DEFAULT, double=double) for x in shares], shares)
        for double in (False, True)
    ]
    torques = np.array([*columns.values()], dtype=float)[1:5]  # usual and smallest coefficient, single and double nuts
    least = np.median(torques[2:] / torques[:2], axis=1)
    cases = [x for x in found if x.kind_of_source == outside.MEASURED]
    one = cases[0]
    words = ", ".join(f"{x.value:g} {x.part.split(', ')[1]}" for x in cases)
    return (
        f"By the sliding of the balls, drag torque grows with the lead to the power {sliding[0]:.2f} (balls pressed on "
        f"four flanks) and {sliding[1]:.2f} (double nut); by the makers' formulas {named}. None of the formulas is right: "
        "Rexroth's is nearest for single nuts, THK's for double nuts, and a K_p that is constant over the lead is far from "
        f"both. With the preload, sliding gives powers of {over[0]:.2f} and {over[1]:.2f}, all formulas 1. A coefficient "
        f"of {nuts.LEAST:g} gives {least[0]:.2f} and {least[1]:.3f} of these torques. For two measured screws (N m: "
        f"{words}) the result is {one.computed.value:.2f} at the default coefficient of {nuts.DEFAULT:g}, band "
        f"{one.computed.low:.2f} to {one.computed.high:.2f} for diameters of 25 to 40 mm and either kind of nut. Which "
        "screw and nut they are is not printed, so they stay open, and worn screws have lost an unprinted part of their "
        "preload. Other measurements (a ratio of friction to load of 0.00055 by NBS, spinning coefficients by NASA) are "
        "open because the radii of their grooves cannot be read."
    )


def drag_torque_table() -> Table:
    """Return the table of drag torque divided by preload and nominal diameter, for several leads: computed, by formulas."""
    rows: list[Row] = []
    nominal = 1e-3 * nuts.SWEPT[0]
    for lead in nuts.SWEPT[1]:
        row: Row = {"lead": lead}
        for mu, double in product((nuts.DEFAULT, nuts.LEAST), (False, True)):
            kind = "double" if double else "single"
            torque = nuts.drag_torque_of_ball(nuts.nut_for_drag_comparison(1e-3 * lead), nuts.SHARE, mu, double=double)
            usual, smallest = f"drag_torque_{kind}", (f"drag_torque_{kind}_at", f"{nuts.LEAST:g}")
            row[usual if mu == nuts.DEFAULT else smallest] = 1e3 * torque / (nuts.SHARE * nominal)
        for name, formula in nuts.FORMULAS.items():
            maker, text = name.replace("P/2 pi", "P/(2 pi)").split(": ")
            row["drag_torque_by_formula", maker, text] = 1e3 * formula(1.0, nominal, 1e-3 * lead) / nominal
        rows.append(row)
    at = f"Nominal diameter {nuts.SWEPT[0]:g} mm, balls of {nuts.BALL:g} mm, {nuts.SHARE:g} N each"
    note = "Torque ratio: drag torque T divided by preload F and nominal diameter d0. P: lead; beta: lead angle. "
    note += f"{at}; friction coefficient {nuts.DEFAULT:g}, or as named."
    title = "Drag torque divided by preload and nominal diameter, for several leads: computed, and by makers' formulas"
    return Table.from_rows("outside-drag", title, rows, note)


def sorted_errors_figure(found: Sequence[outside.PublishedValue]) -> Figure:
    """Draw the sorted errors against published values, one curve for each quantity with more than 20 values.

    ``found``: published values with the computed ones.
    """
    series = []
    judged = outside.group_by_fields([x for x in found if not x.left and not x.scale], "quantity")
    for (quantity,), values in judged.items():
        if len(values) > 20:
            x = [float(k + 1) / len(values) for k in range(len(values))]
            series.append(Series(quantity, x, sorted(v.error_percent for v in values), "line"))
    panel = Panel("error of the computed value", "share of the values with a smaller error", "error_percent", tuple(series))
    title = "Errors of computed values against makers' tables, measurements and other programs, sorted by size"
    return Figure("outside-errors", title, (panel,), "One curve for each quantity with more than 20 published values.", 1)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section that compares computed values with makers' tables, measurements and other programs.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("outside values")
    found = all_published_values(cache)
    texts = (clearances_text(found), nut_rigidity_text(found), loaded_balls_text(found), drag_torque_text(found))
    items = (
        Text((*texts, from_catalogue.catalogue_text())),
        outside.bias_and_scatter_table(found),
        from_catalogue.catalogue_ratios_figure(),
        from_catalogue.catalogue_ratios_table(),
        sorted_errors_figure(found),
        drag_torque_table(),
    )
    return Section(
        "outside", TITLE, (*items, outside.published_values_table(found)), conclusion=band_and_errors_conclusion(found)
    )
