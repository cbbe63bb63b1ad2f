"""Table of the results of a solved scene, with the columns quantity, value, unit, error to expect, and note.

The record field that defines a quantity also states its name, unit, digits, error and note in the table. The terminal, the
HTML page, notebooks and the manual show the same table.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi
from typing import Any

from rollbench.compare.measure import error_percent
from rollbench.compare.models.load_cases import AxisDrive, DutyCycleResults, SceneSolution, ShaftSolution
from rollbench.compare.models.loading import COMPONENTS, NOTHING, LiftOff, LoadPath, Preload
from rollbench.compare.models.model_form import ExpectedModelErrors
from rollbench.compare.models.stiffness import LoadPointStiffness, NutStiffness
from rollbench.compare.quantities import format_by_error, format_range, heading_and_unit
from rollbench.compare.results import scene_json
from rollbench.compare.results.base import Row
from rollbench.compare.results.data import Friction, FrictionBand
from rollbench.lowfi.bearings.tapered_roller import RibContact
from rollbench.lowfi.bearings.torque import BallBearingTorque, RollerBearingTorque
from rollbench.lowfi.rating.catalogue_checks import ShaftLimits
from rollbench.lowfi.rating.contacts import BallContact, EllipseTruncation, Ratings, RollerContact, StaticSafety
from rollbench.lowfi.rating.iso_lives import ModifiedLife, ReferenceLife
from rollbench.lowfi.rating.life import BasicRatingLife, EquivalentLoadLife, SystemLife
from rollbench.lowfi.rating.rigidity import AxialRigidities
from rollbench.meshes.one_arc import InternalClearance
from rollbench.meshes.quantity import QuantityDescription, quantity_descriptions

#: Groups of a JSON summary, in the order of the table's rows, each with the record that defines its quantities. If a group
#: has two records, that one is used whose first key the group contains.
GROUPS: tuple[tuple[str, type], ...] = (
    ("", DutyCycleResults),
    ("loads", scene_json.BallLoadSummary),
    ("loads", scene_json.RollerLoadSummary),
    ("axial", scene_json.AxialResults),
    ("nut", NutStiffness),
    ("load_point", LoadPointStiffness),
    ("", AxialRigidities),
    ("worst_contact", BallContact),
    ("worst_contact", RollerContact),
    ("rib_contact", RibContact),
    ("truncation", EllipseTruncation),
    ("static_safety", StaticSafety),
    ("preload", Preload),
    ("contact_lost", LiftOff),
    ("clearance", InternalClearance),
    ("friction", Friction),
    ("band", FrictionBand),
    ("roller_torque", RollerBearingTorque),
    ("bearing_torque", BallBearingTorque),
    ("drive", AxisDrive),
    ("life", BasicRatingLife),
    ("modified_life", ModifiedLife),
    ("reference_life", ReferenceLife),
    ("standard_life", EquivalentLoadLife),
    ("axis_life", SystemLife),
    ("ratings", Ratings),
    ("shaft", ShaftLimits),
)
#: Fields of `ExpectedModelErrors` whose expected errors are in per cent of the mean contact load.
OF_MEAN = ("percent", "rms_percent")
#: Note in the table of results if the preload is not known.
UNKNOWN = "no equilibrium was found without the scene's loads"
#: Groups of the JSON summary of several nuts or bearings that describe the whole shaft, not one nut or bearing.
OF_ALL = ("axial", "nut", "load_point", "tangent_words", "drive", "axis_life")
#: Columns of the table of nuts and bearings on a shaft: group in the JSON summary of each, key in this group, heading.
OF_SETS = (
    ("nut", "tangent_N_per_um", "rigidity, tangent N/um"),
    ("nut", "across_um", "across um"),
    ("nut", "tilt_mrad", "tilt mrad"),
    ("loads", "max_N", "largest load N"),
    ("worst_contact", "pressure_MPa", "peak pressure MPa"),
    ("static_safety", "factor", "static safety"),
    ("preload", "axial_N", "preload N"),
    ("bearing_torque", "starting_Nmm", "starting torque N mm"),
    ("bearing_torque", "running_Nmm", "running torque N mm"),
    ("roller_torque", "band_Nmm", "roller torque N mm"),
    ("roller_torque", "timken_Nmm", "by Timken N mm"),
    ("life", "L10_million_revolutions", "L10 1e6 rev"),
    ("reference_life", "L10r_million_revolutions", "L10r 1e6 rev"),
)


def solution_rows(solved: SceneSolution | ShaftSolution, *, details: bool = False) -> list[Row]:
    """Return the rows of the table of results of a solved scene.

    For several nuts or bearings on a shaft, the rows of the whole shaft come first, then the rows of the nut or bearing
    with the worst contact.

    Parameters
    ----------
    solved
        The solved scene.
    details
        Whether to include quantities that a designer seldom needs.

    Returns
    -------
    list[Row]
        The rows; empty if there is no equilibrium.
    """
    if solved.derived_results is None:
        return []
    supports = _support_load_rows(solved.derived_results.load_path)
    if isinstance(solved, SceneSolution):
        summary = scene_json.single_set_results_json(solved)
        return [*rows_from_summary_json(summary, solved.expected_errors, details=details), *supports]
    data = scene_json.axis_summary_json(solved)
    whole = {key: data.pop(key) for key in OF_ALL if key in data}
    names = [solved.derived_results.set_results[i].name for i in solved.derived_results.set_indices_by_pressure[:1]]
    worst = rows_from_summary_json(data, solved.expected_errors, details=details) if names else []
    head = rows_from_summary_json(whole, solved.expected_errors, details=details)
    return [*head, *supports, *(Row("nut or bearing, worst contact", name) for name in names), *worst]


def rows_from_summary_json(
    data: Mapping[str, Any], expected_errors: ExpectedModelErrors | None = None, *, details: bool = False
) -> list[Row]:
    """Return the rows of the table of results for the quantities in the JSON summary of a scene.

    Parameters
    ----------
    data
        The JSON summary of a scene.
    expected_errors
        Errors to expect of the values; None if they are not known.
    details
        Whether to include quantities that a designer seldom needs.

    Returns
    -------
    list[Row]
        The rows, in the order of `GROUPS`.
    """
    found = []
    mean = (data.get("loads") or {}).get("mean_N")
    for (group, _), (kind, table, stated) in zip(GROUPS, _summary_groups(data), strict=True):
        for key, x in stated if details else [pair for pair in stated if pair[1].heading]:
            known = expected_errors if table.get("along", "z") == "z" else None  # compared along the axis only
            row = _quantity_row(table, key, x, known, mean) if key != "of" else None
            if row is not None and (details or row.unit or row.value not in ("0", "no")):
                of = _part_of(table) or ("" if x.heading or not group else f"{group.replace('_', ' ')}: ")
                found.append(row._replace(quantity=f"{of}{row.quantity}"))
        found += _missing_value_rows(data, kind)
    return found


def rows_with_reference(
    data: Mapping[str, Any], reference: Mapping[str, Any], expected_errors: ExpectedModelErrors | None
) -> Iterator[tuple[str, str, str, str, str, str]]:
    """Yield a table row for each quantity that the JSON summaries of both a model and the reference contain.

    Parameters
    ----------
    data
        JSON summary of the model.
    reference
        JSON summary of the reference.
    expected_errors
        Errors to expect of the model; None if they are not known.

    Yields
    ------
    tuple[str, str, str, str, str, str]
        Name, value of the model, value of the reference, unit, difference [%], and the error that was expected.
    """
    theirs = {
        (kind, key): _json_value_at(table, key) for kind, table, stated in _summary_groups(reference) for key, _ in stated
    }
    mean = (data.get("loads") or {}).get("mean_N")
    for kind, table, stated in _summary_groups(data):
        for key, x in stated if kind is not Ratings else ():
            value, other = _json_value_at(table, key), theirs.get((kind, key))
            if x.heading and isinstance(value, float) and isinstance(other, float):
                name, unit = _quantity_name_and_unit(x)
                off = f"{float(error_percent(value, other)):+z.2f} %" if other else ""
                expected = _expected_error_of_value(value, x.expected, expected_errors, mean)[1]
                yield f"{_part_of(table)}{name}", format_by_error(value), format_by_error(other), unit, off, expected


def _summary_groups(
    data: Mapping[str, Any],
) -> Iterator[tuple[type, Mapping[str, Any], list[tuple[str, QuantityDescription]]]]:
    """Yield record class, values in a JSON summary, and definitions for each group of quantities in `GROUPS`.

    ``data``: JSON summary of a scene. The values are a mapping, empty if the summary does not contain the group. The
    definitions are pairs of JSON key and definition, for all quantities of the group.
    """
    for group, kind in GROUPS:
        table = data.get(group) if group else data
        stated = [(x.key.removeprefix("torque."), x) for _, x in quantity_descriptions(kind)]
        known = isinstance(table, Mapping) and _json_value_at(table, stated[0][0]) is not ...
        if kind is Preload and table and not table["loaded_contacts"]:
            known = False
        yield kind, table if known and table else {}, stated


def _quantity_name_and_unit(definition: QuantityDescription) -> tuple[str, str]:
    """Return the name and the unit of a quantity as the table of results shows them.

    ``definition``: definition of the quantity.
    """
    name, unit = heading_and_unit(definition)
    return name, unit.replace("million revolutions", "1e6 rev")


def _part_of(table: Mapping[str, Any]) -> str:
    """Return the part or point to which the quantities of a group belong, as the beginning of their names; often empty."""
    return f"{table['of']}: " if "of" in table else ""


def _json_value_at(table: Mapping[str, Any], key: str) -> Any:
    """Return the value at a key of a JSON object; a dot in the key leads into an inner object.

    Returns ``...`` (Ellipsis) if there is no such key.
    """
    value: Any = table
    for name in key.split("."):
        value = value.get(name, ...) if isinstance(value, Mapping) else ...
    return value


def _quantity_row(
    table: Mapping[str, Any],
    key: str,
    definition: QuantityDescription,
    errors: ExpectedModelErrors | None,
    mean: float | None,
) -> Row | None:
    """Return the row of one quantity in the table of results; None if the table cannot show its value.

    Shown are numbers, texts, truth values and ranges of two numbers. ``table``: JSON values of the quantity's group.
    ``key``: key of its value. ``definition``: its definition. ``errors``: errors to expect; None if they are not known.
    ``mean``: mean contact load [N].
    """
    value = _json_value_at(table, key)
    if value in (None, ..., ""):
        return None
    name, unit = _quantity_name_and_unit(definition)
    digits = int(definition.form[1:]) if definition.form in ("g2", "g3") else 4
    if isinstance(value, str):
        return Row(name, "", note=value)
    if isinstance(value, bool | int) and not unit:
        return Row(name, str(value) if type(value) is int else "yes" if value else "no")
    if isinstance(value, list) and len(value) == 2 and all(isinstance(end, float) for end in value):
        return Row(name, format_range(value, digits), unit, "", _fill_note_template(table, definition.note))
    if not isinstance(value, int | float):
        return None
    error, words = _expected_error_of_value(value, definition.expected, errors, mean)
    return Row(name, format_by_error(value, error, digits), unit, words, _fill_note_template(table, definition.note))


def _expected_error_of_value(
    value: float, expected: tuple[str, float], expected_errors: ExpectedModelErrors | None, mean_load: float | None
) -> tuple[float | None, str]:
    """Return the expected error of a value twice: in the unit of the value, and as text in per cent.

    ``expected``: name of the field of `ExpectedModelErrors` with the error in per cent, and a factor by which this error is
    multiplied. ``expected_errors``: errors to expect; None if they are not known. ``mean_load``: mean contact load [N],
    which some errors are relative to. Returns None and an empty text if the error is not known.
    """
    field, times = expected
    percent = getattr(expected_errors, field) if expected_errors is not None and field else None
    if percent is None:
        return None, ""
    whole = mean_load if times == 1.0 and field in OF_MEAN else value
    text = f"{format_by_error(float(f'{times * percent:.2g}'), digits=2)} %"
    return abs(whole or 0.0) * times * percent / 100.0, f"{text} of mean" if whole is mean_load else text


def _fill_note_template(table: Mapping[str, Any], template: str) -> str:
    """Return the note of a table row: a template with its placeholders replaced by values; empty if a value is missing.

    ``table``: JSON values by key. ``template``: text such as ``ball {worst_ball}``.
    """
    known = {key: format_by_error(x) if isinstance(x, float) else x for key, x in table.items() if x is not None}
    values = {key: x.rstrip("0").rstrip(".") if isinstance(x, str) and "." in x else x for key, x in known.items()}
    try:
        return template.format_map(values)
    except KeyError:
        return ""


def _missing_value_rows(data: Mapping[str, Any], kind: type) -> Iterator[Row]:
    """Yield table rows that state why the quantities of the record class ``kind`` have no value.

    ``data``: JSON summary of the scene.
    """
    preload, lost, drive = (data.get(key) or {} for key in ("preload", "contact_lost", "drive"))
    if kind is scene_json.BallLoadSummary and "loads" in data and data["loads"] is None:
        yield Row("contact loads", "none", note="no contact carries load")
    elif kind is LoadPointStiffness and (words := data.get("tangent_words")):
        yield Row("rigidities, tangent", "none", note=words)
    elif kind is Preload and "preload" in data and not preload.get("loaded_contacts"):
        known = "without the loads"
        yield Row("preload", "none" if preload else "not known", note=known if preload else UNKNOWN)
    elif kind is LiftOff and lost.get("words"):
        yield Row("factor on loads that opens a contact", "not known", note=lost["words"])
    elif kind is Friction and data.get("friction_words"):
        yield Row("friction torque", "none", note=data["friction_words"])
    elif kind is AxisDrive and drive and drive["running_torque_Nmm"] is None:
        words = "; ".join(dict.fromkeys(x["words"] for x in drive["sets"] if x["words"]))
        yield Row("motor torque, running", "not known", note=words)
    elif kind is SystemLife and data.get("axis_life") and data["axis_life"]["L10_million_revolutions"] is None:
        yield Row("life L10 of the whole axis", "–", note="L10 of a nut or bearing is not known")
    elif kind is BasicRatingLife and "life" in data and data["life"] is None:
        yield Row("life L10", "–", note=data.get("rating_refused") or data.get("life_words") or "no load")


def _support_load_rows(path: LoadPath | None) -> Iterator[Row]:
    """Yield a table row for each part of the external load that a support carries: one per support and load component.

    ``path``: record of the load that each support carries; None: no rows.
    """
    if path is None:
        return
    for taker in path.support_shares:
        for k, part in enumerate(taker.carried_load):
            if abs(part) > NOTHING * abs(path.applied_load[k]) > 0.0:
                unit = "N" if k < 3 else "N m"
                yield Row("load carried by a support", format_by_error(part), unit, "", f"{COMPONENTS[k]} by {taker.name}")


def bearing_and_nut_rows(solved: ShaftSolution) -> list[dict[str, Any]]:
    """Return a table row for each nut or bearing on a shaft: name, position, axial force, rigidity, loads and life.

    Parameters
    ----------
    solved
        The solved shaft.

    Returns
    -------
    list[dict[str, Any]]
        Texts of each row, by the headings in `OF_SETS` and others. Columns without any value are left out. Empty if there
        is no equilibrium.
    """
    if solved.derived_results is None:
        return []
    found = []
    for k, (s, answers) in enumerate(zip(solved.result.sets, solved.derived_results.set_results, strict=True), 1):
        data = scene_json.nut_or_bearing_summary_json(s, answers, solved.scene.motion)
        row: dict[str, Any] = {"set": f"{k} {s.of.name}", "z mm": f"{1e3 * s.of.position:.1f}"}
        row["axial force N"] = format_by_error(float(s.force[2]))
        for group, key, heading in OF_SETS:
            value = (data.get(group) or {}).get(key)
            shown = format_range if isinstance(value, list) else format_by_error
            row[heading] = None if value is None else shown(value)
        found.append(row)
    return [{key: row[key] or "–" for key in row if any(x[key] for x in found)} for row in found]


def friction_rows(data: Mapping[str, Any]) -> list[Row]:
    """Return the table rows of the friction of a whole screw or bearing, or of several nuts or bearings on one shaft.

    Parameters
    ----------
    data
        JSON that ``rollbench friction`` prints.

    Returns
    -------
    list[Row]
        The rows; empty for other kinds of scene.
    """
    solved = data.get("torque") and data.get("sets", True)
    torque = data["torque"] | {"losses": data.get("losses")} if solved else {}
    if torque and data.get("motion"):
        torque["speed_rpm"] = float(f"{abs(data['motion']['speed_rad_s']) * 30.0 / pi:.6g}")
    band = data.get("band") and data["band"] | dict(zip(("least", "most"), data["band"]["coefficients"], strict=True))
    return rows_from_summary_json({"friction": torque, "band": band, "drive": data.get("drive")})


def duty_cycle_rows(cycle_results: DutyCycleResults) -> list[Row]:
    """Return the table rows with extremes and lives over all load cases of a duty cycle.

    Parameters
    ----------
    cycle_results
        Extremes and lives over all load cases; with several nuts or bearings, the shortest of their lives is shown.

    Returns
    -------
    list[Row]
        The rows.
    """
    rows = rows_from_summary_json(scene_json.cycle_results_json(cycle_results))
    rows = [row._replace(note=cycle_results.shortest) if row.quantity == "life L10" else row for row in rows]
    if cycle_results.uncovered:
        rows.append(Row("error to expect", "not covered", note=f"cases {', '.join(cycle_results.uncovered)}"))
    return rows


def expected_error_sentence(expected_errors: ExpectedModelErrors | None) -> str:
    """Return a sentence on how the expected errors were estimated, or why they are not known.

    Parameters
    ----------
    expected_errors
        The errors to expect; None for several nuts or bearings on one shaft, where they are not known, but for a double
        nut.

    Returns
    -------
    str
        The sentence, without a full stop.
    """
    if expected_errors is None:
        unknown = "not known for several nuts or bearings on one shaft other than a double nut"
        return f"error to expect: {unknown}; measure it by: rollbench compare SCENE"
    nearest, words = expected_errors.nearest, "; ".join(expected_errors.words)
    if expected_errors.percent is None:
        away = f" (most similar scene: {nearest})" if nearest else ""
        return f"error to expect: not covered by the comparisons with the 3D reference{away}; {words}"
    if expected_errors.calibrated:
        like = f"{expected_errors.calibrated} compared scenes that calibrate it"
        smaller = f"nine in ten new scenes drawn like the {like} have a smaller one, most similar: {nearest}"
    else:
        of = f"{expected_errors.compared} similar scene{'s' * (expected_errors.compared != 1)}"
        smaller = (
            f"in nine of ten of {of} the error was smaller, without a guarantee for a new one, most similar: {nearest}"
        )
    return f"error to expect: {smaller}; {words}; measure it by: rollbench compare SCENE"
