"""Table of the results of a solved scene, with the columns quantity, value, unit, error to expect, and note.

The record field that defines a quantity also states its name, unit, digits, error and note in the table. The terminal, the
HTML page, notebooks and the manual show the same table.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rollbench.compare.measure import error_percent
from rollbench.compare.models.load_cases import AxisDrive, DutyCycleResults
from rollbench.compare.models.loading import COMPONENTS, NOTHING, LiftOff, LoadPath, Preload
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.quantities import Quantity, format_by_error, format_range, quantities_of_instance, quantity_value
from rollbench.compare.results.base import Row
from rollbench.lowfi.rating.life import SystemLife
from rollbench.meshes.quantity import quantity_descriptions

#: Keys of records in the results, in the order of the table's rows.
ORDER = (
    "loads",
    "axial",
    "nut",
    "load_point",
    "rigidities",
    "worst_contact",
    "rib_contact",
    "truncation",
    "static_safety",
    "preload",
    "contact_lost",
    "clearance",
    "friction",
    "roller_torque",
    "bearing_torque",
    "drive",
    "life",
    "modified_life",
    "reference_life",
    "standard_life",
    "axis_life",
    "ratings",
    "shaft",
)
#: Fields of `ExpectedError` whose expected errors are in per cent of the mean contact load.
OF_MEAN = ("loads", "loads_rms")
#: Names of the attributes with the records of results, where they differ from the keys.
FIELDS = {"loads": "load_summary", "contact_lost": "lift_off"}
#: Note in the table of results if the preload is not known.
UNKNOWN = "no equilibrium was found without the scene's loads"
#: Columns of the table of nuts and bearings on a shaft: record in the results of each, its quantity, heading.
OF_SETS = (
    ("nut", "force_N", "force by loads N"),
    ("nut", "displacement_um", "displacement um"),
    ("nut", "tangent_N_per_um", "rigidity, tangent N/um"),
    ("nut", "across_um", "across um"),
    ("nut", "tilt_mrad", "tilt mrad"),
    ("loads", "max_N", "largest load N"),
    ("worst_contact", "pressure_MPa", "peak pressure MPa"),
    ("static_safety", "factor", "static safety"),
    ("preload", "axial_N", "preload N"),
    ("contact_lost", "load_factor", "opens at times load"),
    ("bearing_torque", "starting_Nmm", "starting torque N mm"),
    ("bearing_torque", "running_Nmm", "running torque N mm"),
    ("roller_torque", "band_Nmm", "roller torque N mm"),
    ("roller_torque", "timken_Nmm", "by Timken N mm"),
    ("life", "L10_million_revolutions", "L10 1e6 rev"),
    ("reference_life", "L10r_million_revolutions", "L10r 1e6 rev"),
)


def nested_records(record: Any, *without: str) -> dict[str, Any]:
    """Return the records among the quantities of a record by their keys, in the order of `ORDER`; None if not known.

    Parameters
    ----------
    record
        Results, such as those of a nut.
    *without
        Keys that are left out.
    """
    found = {x.key: x.shown(getattr(record, name)) for name, x in quantity_descriptions(type(record))}
    found |= {key: getattr(record, key) for key in ("rigidities", "friction") if hasattr(record, key)}
    return {key: found[key] for key in ORDER if key in found and key not in without}


def record_rows(
    records: Mapping[str, Any],
    expected_error: ExpectedError | None = None,
    parts: Sequence[Any] = (),
    *,
    details: bool = False,
) -> list[Row]:
    """Return the rows of the table of results for the quantities of several records.

    Parameters
    ----------
    records
        Records by the key of each in the results.
    expected_error
        Errors to expect of the values; None if they are not known.
    parts
        Results that contain the records, and say why values are missing.
    details
        Whether to include quantities that a designer seldom needs.

    Returns
    -------
    list[Row]
        The rows, in the order of `ORDER`.
    """
    found: list[Row] = []
    mean = getattr(records.get("loads"), "mean", None)
    for key, record in sorted(records.items(), key=lambda one: ORDER.index(one[0])):
        if record is not None and not (isinstance(record, Preload) and not record.contacts):
            found += group_rows(record, "" if key == "rigidities" else key, expected_error, mean, details=details)
        missing = (row for part in parts for row in _missing_value_rows(key, part))
        found += dict.fromkeys(missing)  # each once: a nut and its scene lack the same
    return found


def group_rows(
    record: Any,
    group: str = "",
    expected_error: ExpectedError | None = None,
    mean: float | None = None,
    *,
    details: bool = False,
) -> Iterator[Row]:
    """Yield the rows of the table of results for the quantities of one record.

    Parameters
    ----------
    record
        The record.
    group
        Key of the record in the results, with which the names of quantities without heading begin.
    expected_error
        Errors to expect of the values; None if they are not known.
    mean
        Mean contact load [N].
    details
        Whether to include quantities that a designer seldom needs.
    """
    known = expected_error if getattr(record, "along", "z") == "z" else None  # compared along the axis only
    for x in quantities_of_instance(record).values():
        if x.key == "of" or not (details or x.described.heading):
            continue
        row = _quantity_row(record, x, known, mean)
        if row is not None and (details or row.unit or row.value not in ("0", "no")):
            of = _part_of(record) or ("" if x.described.heading or not group else f"{group.replace('_', ' ')}: ")
            yield row._replace(quantity=f"{of}{row.quantity}")


def rows_with_reference(
    records: Mapping[str, Any], reference: Mapping[str, Any], expected_error: ExpectedError | None
) -> Iterator[tuple[str, str, str, str, str, str]]:
    """Yield a table row for each quantity that the results of both a model and the reference contain.

    Parameters
    ----------
    records, reference
        Records of the model and of the reference, by the key of each in the results.
    expected_error
        Errors to expect of the model; None if they are not known.

    Yields
    ------
    tuple[str, str, str, str, str, str]
        Name, value of the model, value of the reference, unit, difference [%], and the error that was expected.
    """
    mean = getattr(records.get("loads"), "mean", None)
    for group, record in records.items():
        for x in quantities_of_instance(record).values() if group != "ratings" else ():
            value, other = quantity_value(record, x.key), quantity_value(reference.get(group), x.key)
            if x.described.heading and isinstance(value, float) and isinstance(other, float):
                off = f"{float(error_percent(value, other)):+z.2f} %" if other else ""
                expected = _expected_error_of_value(value, x.described.expected, expected_error, mean)[1]
                values = format_by_error(value), format_by_error(other)
                yield f"{_part_of(record)}{x.label}", *values, _short_unit(x), off, expected


def _short_unit(quantity: Quantity) -> str:
    """Return the unit of a quantity as the table of results shows it."""
    return quantity.unit.replace("million revolutions", "1e6 rev")


def _part_of(record: Any) -> str:
    """Return the part or point to which the quantities of a record belong, as the beginning of their names; often empty."""
    return f"{record.of}: " if hasattr(record, "of") else ""


def _quantity_row(record: Any, quantity: Quantity, errors: ExpectedError | None, mean: float | None) -> Row | None:
    """Return the row of one quantity in the table of results; None if the table cannot show its value.

    Shown are numbers, texts, truth values and ranges of two numbers. ``record``: record with the quantity. ``errors``:
    errors to expect; None if they are not known. ``mean``: mean contact load [N].
    """
    value, stated = quantity.value(record), quantity.described
    if value in (None, ""):
        return None
    name, unit = quantity.label, _short_unit(quantity)
    digits = int(stated.form[1:]) if stated.form in ("g2", "g3") else 4
    if isinstance(value, str):
        return Row(name, "", note=value)
    if isinstance(value, bool | int) and not unit:
        return Row(name, str(value) if type(value) is int else "yes" if value else "no")
    if isinstance(value, list) and len(value) == 2 and all(isinstance(end, float) for end in value):
        return Row(name, format_range(value, digits), unit, "", _fill_note_template(record, stated.note))
    if not isinstance(value, int | float):
        return None
    error, words = _expected_error_of_value(value, stated.expected, errors, mean)
    return Row(name, format_by_error(value, error, digits), unit, words, _fill_note_template(record, stated.note))


def _expected_error_of_value(
    value: float, expected: tuple[str, float], expected_errors: ExpectedError | None, mean_load: float | None
) -> tuple[float | None, str]:
    """Return the expected error of a value twice: in the unit of the value, and as text in per cent.

    ``expected``: name of the field of `ExpectedError` with the error in per cent, and a factor by which this error is
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


def _fill_note_template(record: Any, template: str) -> str:
    """Return the note of a table row: a template with its placeholders replaced by values; empty if a value is missing.

    ``record``: record with the values. ``template``: text such as ``ball {worst_ball}``, with keys of quantities.
    """
    found = {x.key: x.value(record) for x in quantities_of_instance(record).values() if f"{{{x.key}" in template}
    known = {key: format_by_error(x) if isinstance(x, float) else x for key, x in found.items() if x is not None}
    values = {key: x.rstrip("0").rstrip(".") if isinstance(x, str) and "." in x else x for key, x in known.items()}
    try:
        return template.format_map(values)
    except KeyError:
        return ""


def _missing_value_rows(key: str, part: Any) -> Iterator[Row]:
    """Yield table rows that state why the record ``key`` of some results has no value; ``part``: the results."""
    found: Any = getattr(part, FIELDS.get(key, key), ...)
    if key == "loads" and found is None:
        yield Row("contact loads", "none", note="no contact carries load")
    elif key == "load_point" and found is not ... and part.tangent_words:
        yield Row("rigidities, tangent", "none", note=part.tangent_words)
    elif key == "preload" and hasattr(part, "lift_off") and not (found and found.contacts):
        yield Row("preload", "none" if found else "not known", note="without the loads" if found else UNKNOWN)
    elif isinstance(found, LiftOff) and found.words:
        yield Row("factor on loads that opens a contact", "not known", note=found.words)
    elif key == "friction" and found is not ... and part.friction_words:
        yield Row("friction torque", "none", note=part.friction_words)
    elif isinstance(found, AxisDrive) and found.running is None:
        words = "; ".join(dict.fromkeys(x.words for x in found.sets if x.words))
        yield Row("motor torque, running", "not known", note=words)
    elif isinstance(found, SystemLife) and found.basic is None:
        yield Row("life L10 of the whole axis", "–", note="L10 of a nut or bearing is not known")
    elif key == "life" and found is None and hasattr(part, "life_by_loads"):
        words = getattr(part, "rating_refused", "") or part.life_words or "no load"
        yield Row("life L10", "–", note=words)


def support_load_rows(path: LoadPath | None) -> Iterator[Row]:
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


#: Value of a cell below which it is a round-off error of zero, such as the net preload of a nut with larger balls [N].
ROUND_OFF = 1e-9


def bearing_and_nut_rows(sets: Mapping[str, SetResult]) -> list[dict[str, Any]]:
    """Return a table row for each nut or bearing on a shaft: name, position, axial force, rigidity, loads and life.

    Parameters
    ----------
    sets
        Results of each nut or bearing by name.

    Returns
    -------
    list[dict[str, Any]]
        Texts of each row, by the headings in `OF_SETS` and others. Columns without any value are left out.
    """
    found = []
    for k, s in enumerate(sets.values(), 1):
        records = nested_records(s)
        row: dict[str, Any] = {"set": f"{k} {s.name}", "z mm": f"{1e3 * s.position:.1f}"}
        row["force on shaft N"] = None if s.force is None else format_by_error(float(s.force[2]))
        for group, key, heading in OF_SETS:
            value = quantity_value(records.get(group), key)
            if isinstance(value, float) and abs(value) < ROUND_OFF:
                value = 0.0
            shown = format_range if isinstance(value, list) else format_by_error
            row[heading] = None if value is None else shown(value)
        found.append(row)
    return [{key: row[key] or "–" for key in row if any(x[key] for x in found)} for row in found]


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
    lives = cycle_results.shortest_lives
    records = nested_records(lives) | ({"axis_life": cycle_results.axis_life} if len(cycle_results.lives) > 1 else {})
    rows = [*group_rows(cycle_results), *record_rows(records, None, (lives, cycle_results))]
    rows = [row._replace(note=cycle_results.shortest) if row.quantity == "life L10" else row for row in rows]
    if cycle_results.uncovered:
        rows.append(Row("error to expect", "not covered", note=f"cases {', '.join(cycle_results.uncovered)}"))
    return rows


def expected_error_sentence(expected_errors: ExpectedError | None) -> str:
    """Return a sentence on how the expected errors were estimated, or why they are not known.

    Parameters
    ----------
    expected_errors
        The errors to expect; None without an equilibrium.

    Returns
    -------
    str
        The sentence, without a full stop.
    """
    if expected_errors is None:
        return "error to expect: not known without an equilibrium"
    nearest, words = expected_errors.nearest, "; ".join(expected_errors.words)
    words += "; measure it by: rollbench compare SCENE"
    if expected_errors.loads is None:
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
    return f"error to expect: {smaller}; {words}"
