"""Tables in which the terminal shows the friction of a scene, from the fields of its records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from rollbench.compare.quantities import count_with_noun, format_range, quantity_value, record_as_json
from rollbench.compare.results.base import known_values
from rollbench.compare.results.friction import Friction, FrictionOfRollers, FrictionOnset
from rollbench.compare.results.friction_parts import FrictionOfBearingBall, FrictionOfNeighbours, FrictionOfTwoBearings
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.screw import travel

#: Table of the terminal: title, and rows of values by the key of the column.
Shown: TypeAlias = "tuple[str, list[dict[str, Any]]]"

#: One inch times one pound-force [N mm].
INCH_POUND = 25.4 * 4.4482216152605

#: Keys of a ball that the table of balls shows.
OF_BALL = (
    *("set", "index", "state", "azimuth_deg", "load_N", "velocity_apart_mm_s", "deviation_apart_percent"),
    *("velocity_touching_mm_s", "orbit_rad_s", "rotation_rad_s", "closing_mm_s", "loss_mW", "groove_loss_mW"),
)

#: Keys of the torques of a nut or bearing that the table of nuts and bearings shows.
OF_SET = ("set", "name", "friction_torque_Nmm", "drag_torque_Nmm", "axial_load_N", "driving_torque_on_screw_Nmm", "loss_W")

#: Keys of the torques that the table of load cases shows.
OF_CASE = ("axial_load_N", "friction_torque_Nmm", "drag_torque_Nmm", "efficiency_forward_percent")

#: Number of rows of the table over the angle of rotation.
ROWS = 12


def format_three_digits(value: float) -> str:
    """Return a value as text with three significant digits, without exponent below a million."""
    return f"{float(f'{value:.3g}'):g}"


def _selected(rows: Iterable[Mapping[str, Any]], keys: Sequence[str]) -> list[dict[str, Any]]:
    """Return the values of rows at some keys, with a column for each entry of a value that is a list or an object."""
    return [known_values({key: row[key] for key in keys if key in row}) for row in rows]


def friction_tables(found: Friction, *, balls: bool) -> list[Shown]:
    """Return the tables of the terminal on the friction of a scene; ``balls``: also those with a row for each ball.

    The balls of single parts are always shown.
    """
    if found.cases:
        of_cases = [
            {"case": name, "share": one.share, "status": one.reason}
            | {key: quantity_value(one, f"torque.{key}") for key in OF_CASE}
            for name, one in found.cases.items()
        ]
        each = ((name, *table) for name, one in found.cases.items() for table in friction_tables(one, balls=balls))
        return [("load cases", of_cases), *((f"case {name}: {title}", rows) for name, title, rows in each)]
    whole = type(found) is Friction
    tables = [
        ("losses by contact and cause", [record_as_json(row) for row in found.by_contact]),
        (
            "ball nuts and ball bearings: friction of their contacts",
            _selected((one.as_json() for one in found.sets or ()), OF_SET),
        ),
        ("torque that turns the shaft", [record_as_json(one) for one in found.drive.sets] if found.drive else []),
        (
            "rows of tapered rollers: friction torque (from 0.03 to 0.15 of rib friction where none is given)",
            [_torque_of_rollers(one) for one in found.roller_torques],
        ),
        ("over the coefficient of friction", [one.as_json() for one in found.over] if len(found.over) > 1 else []),
        ("torque over the angle", [] if found.run is None else torque_rows_over_angle(found.run.history)),
    ]
    if isinstance(found, FrictionOfNeighbours):
        tables.append(("between balls", [record_as_json(pair) for pair in found.pairs]))
    if isinstance(found, FrictionOfTwoBearings):
        tables.append(("over the load's angle", _torques_over_load_angle(found)))
    if isinstance(found, FrictionOfBearingBall):
        tables.append(("per contact", _contacts_of_ball(found)))
    elif balls or not whole:
        tables.append(("per ball", _selected(map(record_as_json, found.balls), OF_BALL)))
    return [(title, rows) for title, rows in tables if rows]


def has_table_of_balls(found: Friction) -> bool:
    """Return whether there is a table with a row for each ball, which is shown on request."""
    return any(type(one) is Friction and one.balls for one in (found.cases or {"": found}).values())


def _torque_of_rollers(one: FrictionOfRollers) -> dict[str, Any]:
    """Return the row of a row of tapered rollers: its friction torque as a band, and by Timken's formula."""
    band, timken = (quantity_value(one.torque, key) for key in ("band_Nmm", "timken_Nmm"))
    return {
        "name": one.name,
        "friction torque N mm": format_range(band),
        "friction torque in-lbf": format_range([x / INCH_POUND for x in band]),
        "by Timken N mm": timken,
        "by Timken in-lbf": timken and timken / INCH_POUND,
    }


def _contacts_of_ball(found: FrictionOfBearingBall) -> list[dict[str, Any]]:
    """Return a row for each loaded contact of a ball of a bearing, with all that is known of the contact."""
    (ball,) = found.balls
    known = {key: value for key, value in record_as_json(ball).items() if isinstance(value, Mapping)}
    loaded = (side for side in bearing.SIDES if (ball.load[side] or 0.0) > 0.0)
    return [known_values({"contact": side} | {key: value.get(side) for key, value in known.items()}) for side in loaded]


def _torques_over_load_angle(found: FrictionOfTwoBearings) -> list[dict[str, Any]]:
    """Return a row for each angle of the load, with the friction torques of a four-point and of a double-row bearing."""
    four, double = found.four_point, found.double_row
    if four is None or double is None:
        return []
    columns = {
        "load angle deg": np.degrees(found.load_angle).tolist(),
        "four-point N mm": [1e3 * torque for torque in four.torque],
        "double row N mm": [1e3 * torque for torque in double.torque],
        "four-point over double row": found.ratio,
        "balls of the four-point beyond two contacts": four.beyond,
        "converged": [f and d for f, d in zip(four.converged, double.converged, strict=True)],
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def torque_rows_over_angle(history: travel.TravelHistory) -> list[dict[str, Any]]:
    """Return table rows of the friction torque over the angle of rotation, at most `ROWS`, evenly spaced."""
    which = np.unique(np.linspace(0, history.time.size - 1, min(ROWS, history.time.size)).round().astype(int))
    return [
        {
            "angle deg": float(np.degrees(history.rotation_angle[k])),
            "torque N mm": float(1e3 * history.torque[k]),
            "grooves N mm": float(1e3 * history.groove_torque[k]),
            "ball to ball N mm": float(1e3 * (history.ball_torque[k] + history.closing_torque[k])),
            "balls loaded": int(history.loaded[k].sum()),
            "groups touching": int(history.touching_group_counts[k]),
        }
        for k in (which if history.begun_step_count else ())
    ]


def onset_sentences(found: Friction) -> list[str]:
    """Return a sentence for each load case on whether neighbouring balls come to touch, and after which rotation."""
    out = []
    for name, one in (found.cases or {"": found}).items():
        if one.onset is not None:
            turns = "inner ring" if one.kind == "bearing" and one.turns == "screw" else str(one.turns)
            out.append(f"case {name}: " * bool(name) + _sentence_on_onset(one.onset, turns))
    return out


def _sentence_on_onset(onset: FrictionOnset, turns: str) -> str:
    """Return a sentence on whether neighbouring balls come to touch, and after which rotation.

    ``turns``: name of the turning part, such as "screw".
    """

    def angle_text(value: float | None) -> str:
        """Return a clause on the rotation ``value`` [rad] after which balls meet; "never" if it is None."""
        return "never" if value is None else f"after {format_three_digits(np.degrees(value))} deg of the {turns}"

    text = f"neighbours {'touch' if onset.touch else 'do not touch'}"
    if onset.first is None:
        text += ": none approach each other"
    else:
        text += (
            f": {onset.closing} of {onset.pairs} pairs approach each other, balls {onset.ball} and the next meet "
            f"{angle_text(onset.first)}"
        )
        text += "" if onset.touch else ", but only after they have left their loaded arc or gone round once"
    if onset.unloaded:
        stand, roll = count_with_noun(onset.unloaded, "unloaded ball"), angle_text(onset.rolling)
        text += f"; this holds if the {stand} stand still, {roll} if they roll along"
    if onset.has_errors and onset.factor is None:
        text += "; with up to 16 times the geometric errors of the scene they do not touch"
    elif onset.has_errors:
        where = f"from {onset.factor:.2g} times the scene's errors on" if onset.factor else "without errors too"
        text += f"; they touch {where}"
    return text
