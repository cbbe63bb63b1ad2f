"""Text lines and tables in which the terminal shows the friction of a scene, from the fields of its record."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from rollbench.compare.quantities import count_with_noun, format_range, json_number, quantity_value
from rollbench.compare.results import friction_parts as parts
from rollbench.compare.results.friction import Friction, FrictionBall, FrictionBand, FrictionOnset
from rollbench.compare.results.friction_run import QUANTITIES, TransientRun, why_no_step_error
from rollbench.compare.text.printing import Column, format_cell
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.screw import travel
from rollbench.lowfi.friction.whole.losses import CAUSES
from rollbench.meshes.parts import SIDES

#: Text line of the terminal: label and text.
Line: TypeAlias = "tuple[str, str]"

#: Table of the terminal: title, columns, and rows, which are records or values by the key of the column.
Shown: TypeAlias = "tuple[str, Sequence[Column], Sequence[Any]]"

#: Labels of text lines that the terminal always shows.
ALWAYS = ("touch",)

#: Labels of the text lines on the unbalanced forces of the solver and on the friction law, which --verbose shows.
BEHIND = ("solver", "law")

#: Relative change of the contact losses by Heathcote slip above which a warning is given in place of a line.
WIDE = 0.03

#: One inch times one pound-force [N mm].
INCH_POUND = 25.4 * 4.4482216152605


def _rotation(ball: FrictionBall, axis: int) -> float | None:
    """Return the rotation of a ball [rad/s] across, along or normal to its track, ``axis`` 0 to 2; None if not known."""
    return None if ball.rotation is None else ball.rotation[axis]


def _carried_load(ball: FrictionBall, side: str) -> float | None:
    """Return the load [N] of a ball on the flank ``side``; None without load."""
    load = ball.load.get(side)
    return load if load is not None and load > 0.0 else None


def _lost_milliwatts(ball: FrictionBall, side: str) -> float | None:
    """Return the power lost on the flank ``side`` of a ball [mW]; None without load."""
    loss = None if ball.loss is None or _carried_load(ball, side) is None else ball.loss[side]
    return None if loss is None else 1e3 * loss


#: Columns of the terminal's table of balls; N stands for the contact load, mW for the friction loss on a flank.
BALL_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    ("azimuth_deg", "azimuth deg", ".2f"),
    ("orbit_rad_s", "orbit rad/s", ".6g"),
    *((partial(_rotation, axis=k), f"omega_{n}", ".5g") for k, n in enumerate("xyz")),
    ("closing_mm_s", "closing mm/s", ".3g"),
    *((partial(_carried_load, side=s), f"{s} N", ".2f") for s in SIDES),
    *((partial(_lost_milliwatts, side=s), f"{s} mW", ".4g") for s in SIDES),
)

#: Columns of the table over the coefficient of friction: the coefficient, two torques, then what only a screw has.
OVER_COLUMNS: tuple[Column, ...] = (
    ("screw", "coefficient", ".4g"),
    ("torque.friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("torque.drag_torque_Nmm", "drag torque N mm", ".5g"),
    ("torque.forward_torque_Nmm", "driving torque forward N mm", ".6g"),
    ("torque.backward_torque_Nmm", "braking torque backward N mm", ".6g"),
    ("torque.efficiency_forward_percent", "efficiency forward %", ".2f"),
    ("torque.efficiency_backward_percent", "efficiency backward %", ".2f"),
    ("torque.self_locking", "self-locking", "s"),
)

#: Columns of the terminal's table of friction losses by contact and cause.
LOSS_COLUMNS: tuple[Column, ...] = (
    ("contact", "contact", "s"),
    ("mean_load_N", "mean load N", ".4g"),
    ("mean_load_without_friction_N", "without friction N", ".4g"),
    ("loss_W", "loss W", ".4g"),
    *((name, f"{name.removeprefix('sliding_')} W", ".4g") for name in CAUSES),
    ("with_curvature_W", "curved W", ".4g"),
)

#: Columns of the table of nuts and ball bearings.
SET_COLUMNS: tuple[Column, ...] = (
    ("set", "set", "s"),
    ("name", "name", "s"),
    ("torque.friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("torque.drag_torque_Nmm", "drag torque N mm", ".5g"),
    ("torque.axial_load_N", "axial load N", ".5g"),
    ("torque.driving_torque_on_screw_Nmm", "torque on the shaft N mm", ".5g"),
    ("loss_W", "loss W", ".5g"),
)

#: Columns of the table of torques that turn the shaft.
DRIVE_COLUMNS: tuple[Column, ...] = (
    ("name", "name", "s"),
    (lambda one: format_range(quantity_value(one, "running_Nmm")), "at constant speed N mm", "s"),
    (lambda one: format_range(quantity_value(one, "starting_Nmm")), "from rest N mm", "s"),
    ("seals_Nmm", "seals as given N mm", ".4g"),
)

#: Columns of the table of rows of tapered rollers.
ROLLER_COLUMNS: tuple[Column, ...] = (
    ("name", "name", "s"),
    (lambda one: format_range(quantity_value(one.torque, "band_Nmm")), "friction torque N mm", "s"),
    (lambda one: format_range([x / INCH_POUND for x in quantity_value(one.torque, "band_Nmm")]), "in-lbf", "s"),
    (lambda one: quantity_value(one.torque, "timken_Nmm"), "by Timken N mm", ".6g"),
    (lambda one: one.torque.timken and 1e3 * one.torque.timken / INCH_POUND, "in-lbf", ".4g"),
)

#: Columns of the table over the coefficient of friction, of a shaft.
OVER_COLUMNS_OF_SHAFT: tuple[Column, ...] = (
    ("screw", "coefficient", ".4g"),
    ("torque.friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("torque.driving_torque_on_screw_Nmm", "torque on the shaft N mm", ".5g"),
)

#: Columns of the table of load cases.
CASE_COLUMNS: tuple[Column, ...] = (
    ("case", "case", "s"),
    ("share", "share", ".4g"),
    ("torque.axial_load_N", "axial load N", ".5g"),
    ("torque.friction_torque_Nmm", "friction torque N mm", ".5g"),
    ("torque.drag_torque_Nmm", "drag N mm", ".4g"),
    ("torque.efficiency_forward_percent", "efficiency %", ".4g"),
)

#: Number of rows of the table in the terminal.
ROWS = 12

#: Columns of the table of the torque over the angle.
ANGLE_COLUMNS: tuple[Column, ...] = (
    ("angle_deg", "angle deg", ".2f"),
    ("torque_Nmm", "torque N mm", ".5g"),
    ("groove_Nmm", "grooves N mm", ".5g"),
    ("balls_Nmm", "ball to ball N mm", ".4g"),
    ("loaded", "balls loaded", "d"),
    ("groups", "groups touching", "d"),
)

#: Columns of the terminal's table of two screw balls, apart and touching.
PAIR_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    ("state", "state", "s"),
    *((lambda ball, s=s: ball.load[s], f"{s} N", ".3f") for s in SIDES),
    ("orbit_rad_s", "orbit rad/s", ".6f"),
    *((partial(_rotation, axis=k), f"omega_{n} rad/s", ".4f") for k, n in enumerate("xyz")),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)

#: Columns of the terminal's table on a simulation over time.
RUN_COLUMNS: tuple[Column, ...] = (("quantity", "quantity with its unit", "s"), ("value", "value in this unit", "s"))

#: Rows of this table: key in the summary, quantity with its unit, and number format.
RUN_LINES = (
    ("largest_ball_to_groove_percent", "largest ratio of torque by ball-to-ball contact to torque of the grooves %", ".4g"),
    ("largest_at_deg", "nut angle at this largest ratio deg", ".4g"),
    ("contact_begins_deg", "nut angle where contact begins deg", ".4g"),
    ("contact_ends_deg", "nut angle where contact first ends after the largest ratio deg", ".4g"),
    ("contact_ends_within_deg", "uncertainty of the nut angle where contact ends deg", ".4g"),
    ("largest_groups", "largest number of groups of touching balls", "d"),
    ("mean_torque_Nmm", "mean torque N mm", ".5g"),
    ("mean_groove_torque_Nmm", "part of the grooves in the mean torque N mm", ".5g"),
    ("mean_ball_torque_Nmm", "part of ball-to-ball contact in the mean torque N mm", ".5g"),
    ("mean_closing_torque_Nmm", "part of closing gaps between balls in the mean torque N mm", ".3g"),
    ("groove_variation_percent", "variation of the grooves' torque %", ".4g"),
    ("largest_ball_force_N", "largest ball-to-ball force N", ".5g"),
    ("order_kept", "order of balls kept", "s"),
    ("smallest_gap_um", "smallest gap um", ".3g"),
    ("occupation_percent", "loaded track filled by all balls %", ".4g"),
)

#: Columns of the terminal's table of the loaded contacts of one ball; a and b are the semi-axes of the contact ellipse
#: across and along the groove.
CONTACT_COLUMNS = (
    ("side", "contact", "s"),
    ("load_N", "force N", ".4f"),
    ("contact_angle_deg", "angle deg", ".4f"),
    ("semi_axis_across_um", "a um", ".1f"),
    ("semi_axis_along_um", "b um", ".1f"),
    ("slide", "sliding mm/s", ".4f"),
    ("spin_rad_s", "spin rad/s", ".4f"),
    ("along", "friction N", ".5f"),
    ("moment_Nmm", "moment N mm", ".5f"),
    ("loss_mW", "loss mW", ".4f"),
    ("at_rest", "at rest", "s"),
)

#: Columns of the terminal's table of friction torques of both bearings over the angle of the load.
BEARING_COLUMNS = (
    ("angle", "load angle deg", ".4g"),
    ("four", "four-point N mm", ".5g"),
    ("double", "double row N mm", ".5g"),
    ("over", "four-point over double row", ".4g"),
    ("beyond", "balls of the four-point beyond two contacts", "d"),
    ("converged", "converged", "s"),
)

#: Columns of the terminal's table of balls; v is the velocity of a ball, "apart" means balls too far apart to touch.
LINEAR_BALL_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    *((lambda ball, c=c: ball.load[c], f"{c} N", ".3f") for c in linear_bearing.CONTACTS),
    ("velocity_apart_mm_s", "v apart mm/s", ".5f"),
    ("deviation_apart_percent", "v apart above half the carriage's %", ".4f"),
    ("velocity_touching_mm_s", "v mm/s", ".5f"),
    *((partial(_rotation, axis=k), f"omega_{n} rad/s", ".4f") for k, n in enumerate("xy")),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)

#: Columns of the terminal's table of pairs of neighbouring balls.
NEIGHBOUR_COLUMNS: tuple[Column, ...] = (
    ("balls", "balls", "s"),
    ("gap_um", "gap um", ".3f"),
    ("force_N", "force N", ".4f"),
    ("loss_mW", "loss mW", ".5f"),
)


def format_three_digits(value: float) -> str:
    """Return a value as text with three significant digits, without exponent below a million."""
    return f"{float(f'{value:.3g}'):g}"


def friction_lines(found: Friction) -> list[Line]:
    """Return the text lines of the terminal on the friction of a scene of any kind, each with its label."""
    if found.cases:
        return _lines_on_cases(found)
    if found.law is None:
        return []
    if isinstance(found, parts.FrictionOfTwoBearings) and found.four_point is None:
        return []
    if kind := next((lines for of, (lines, _) in OF_PARTS.items() if isinstance(found, of)), None):
        return kind(found)
    if found.sets is not None:
        return _lines_on_shaft(found)
    return [*_lines_on_screw_or_bearing(found), *([] if found.run is None else lines_on_simulation(found.run))]


def friction_tables(found: Friction) -> list[Shown]:
    """Return the tables of the terminal on the friction of a scene of any kind, without those of all balls."""
    if found.cases:
        return [("load cases", CASE_COLUMNS, [*found.cases.values()]), *_of_cases(found, friction_tables)]
    if found.law is None:
        return []
    if kind := next((tables for of, (_, tables) in OF_PARTS.items() if isinstance(found, of)), None):
        return [table for table in kind(found) if table[2]]
    if found.sets is not None:
        return _tables_of_shaft(found)
    tables: list[Shown] = []
    if _carries_load(found):
        tables.append(("losses by contact and cause", LOSS_COLUMNS, found.by_contact))
    if len(found.over) > 1:
        columns_over = OVER_COLUMNS[:3] if found.kind == "bearing" else OVER_COLUMNS
        tables.append(("over the coefficient of friction", columns_over, found.over))
    if found.run is not None and found.run.history.begun_step_count:
        tables.append(("torque over the angle", ANGLE_COLUMNS, torque_rows_over_angle(found.run.history)))
    return tables


def ball_tables(found: Friction) -> list[Shown]:
    """Return the tables of the terminal with a row for each ball, which are shown on request."""
    if found.cases:
        return _of_cases(found, ball_tables)
    if found.law is None or not found.balls or isinstance(found, tuple(OF_PARTS)):
        return []
    if found.sets is not None:
        return [("per ball", (("set", "set", "s"), *BALL_COLUMNS), found.balls)]
    return [("per ball", BALL_COLUMNS, found.balls)] if _carries_load(found) else []


def _of_cases(found: Friction, tables: Callable[[Friction], list[Shown]]) -> list[Shown]:
    """Return the tables of all load cases, with the name of the case in their titles."""
    return [(f"case {name}: {title}", *rest) for name, one in found.cases.items() for title, *rest in tables(one)]  # type: ignore[misc]


def _carries_load(found: Friction) -> bool:
    """Return whether any contact carries load."""
    return any((load or 0.0) > 0.0 for ball in found.balls for load in ball.load.values())


def _lines_on_cases(found: Friction) -> list[Line]:
    """Return terminal lines (label, text) on the load cases of a duty cycle, first those on all of them."""
    both = found.together
    assert both is not None
    largest = "none" if both.largest is None else f"{format_three_digits(1e3 * both.largest)} N mm in case {both.case}"
    mean = (both.words or "") if both.mean is None else f"{format_three_digits(1e3 * both.mean)} N mm"
    lines = [("torque", f"largest of friction {largest}; mean over the duty cycle {mean}")]
    for name, one in found.cases.items():
        lines += [("", ""), ("case", f"{name}, share {one.share:.4g}: {one.reason}"), *friction_lines(one)]
    return lines


def line_on_remaining_imbalance(found: Friction) -> Line:
    """Return a terminal line (label, text) on the imbalance that the solver leaves in contact loads and in friction."""
    loads = f"contact loads with a residual of {found.residual:.1e}"
    return "solver", f"{loads}, friction out of balance by {found.imbalance:.1e} of its bound"


# --- a whole screw or bearing


def _line_on_driving_torque(found: Friction, part: str) -> Line:
    """Return a terminal line (label, text) on the torque that a motor must give or a brake must hold.

    ``part``: name of the part that turns.
    """
    role = "which a motor must give" if (found.torque_power or 0.0) >= 0.0 else "with which a brake must hold"
    moving = "" if found.load_moves is None else f", which moves {found.load_moves}"
    torque = format_three_digits(abs(1e3 * (found.driving_torque_on_screw or 0.0)))
    return "torque", f"{torque} N mm, {role} the {part} at {found.speed:.6g} rad/s{moving}"


def lines_on_friction_of_screw(found: Friction) -> list[Line]:
    """Return terminal lines (label, text) on the friction of a whole screw or bearing, the driving torque first.

    Values that depend on the coefficient of friction are shown with three digits, as that coefficient is hardly known to
    one.
    """
    ring = found.kind == "bearing"
    inner, outer = ("inner ring", "outer ring") if ring else ("screw", "nut")
    remark = found.drag_unknown or found.drag_note
    if found.drag_torque is None:
        without = f"unknown: {remark}"
    else:
        without = f"{format_three_digits(1e3 * found.drag_torque)} N mm" + (f" ({remark})" if remark else "")
    torque = f"torque {format_three_digits(1e3 * (found.torque or 0.0))} N mm of {inner} in {outer}"
    lines = [
        _line_on_driving_torque(found, inner if found.turns == "screw" else outer),
        ("friction", f"{torque}; drag torque without loads {without}"),
    ]
    bare = f"{format_three_digits(1e3 * (found.torque_without_feedback or 0.0))} N mm"
    if found.touching is not None:
        n = found.touching
        text = (
            f"{n.pairs} pairs of neighbours touch, with up to {max(n.force, default=0.0):.3g} N; "
            f"between balls {n.loss:.3g} W are lost; without them the friction torque is {bare}"
        )
        lines.append(("balls", text))
    elif not ring and found.torque != 0.0:
        how = "friction moves the balls in their grooves" if found.coupled else "loads are those without friction"
        text = (
            f"{how}: it pulls the screw along its axis with {found.axial_friction:.3g} N and a ball across its path "
            f"with up to {found.friction_over_load:.3g} of its largest load"
        )
        fed = f"; without this feedback the friction torque is {bare}" if found.coupled else ""
        lines.append(("feedback", text + fed))
    return lines


def _lines_on_screw_or_bearing(found: Friction) -> list[Line]:
    """Return terminal lines (label, text) on the friction of a whole screw or bearing at one instant."""
    lines = lines_on_friction_of_screw(found)
    if found.band is not None and _carries_load(found):
        lines += _lines_on_drag_torque(found.band)
    if found.onset is not None:
        turns = "inner ring" if found.kind == "bearing" and found.turns == "screw" else str(found.turns)
        lines.append(_line_on_ball_to_ball_contact(found.onset, turns))
    lines.append(line_on_remaining_imbalance(found))
    if found.torque and found.slip is not None and abs(found.slip) <= WIDE:
        lines.append(("slip", "contacts are not flat: " + heathcote_slip_clause(found.slip)))
    return lines


def heathcote_slip_clause(loss_increase: float) -> str:
    """Return a clause that says by how many per cent the neglected Heathcote slip would change friction.

    ``loss_increase``: ratio of the additional losses by Heathcote slip to the losses without it.
    """
    percent = f"{100.0 * loss_increase:+.2g} %"
    return f"their curvature (Heathcote slip) would change the friction torque, which leaves it out, by {percent}"


def _lines_on_drag_torque(band: FrictionBand) -> list[Line]:
    """Return a terminal line (label, text) on the drag torque at both measured coefficients and by the makers' formula.

    The list is empty for a scene without preload.
    """
    if band.makers is None:
        return []
    torques = " to ".join("(none found)" if x is None else f"{1e3 * x:.3g}" for x in band.drag_torque or ())
    least, most = band.coefficients
    text = (
        f"without load {torques} N mm at coefficients of friction from {least:g} "
        f"to {most:g}; makers' formula 0.05/sqrt(tan(lead angle)) F l/(2 pi) for the preload of "
        f"{band.preload:.4g} N: {format_three_digits(1e3 * band.makers)} N mm"
    )
    return [("drag", text)]


def _line_on_ball_to_ball_contact(onset: FrictionOnset, turns: str) -> Line:
    """Return a terminal line (label, text) on whether neighbouring balls come to touch, and after which rotation.

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
    return "touch", text


# --- a shaft


def _lines_on_shaft(found: Friction) -> list[Line]:
    """Return terminal lines (label, text) on the friction of the nuts and bearings of a shaft."""
    left = line_on_remaining_imbalance(found)
    if not found.sets:
        return [left]
    text = (
        f"{1e3 * (found.driving_torque_on_screw or 0.0):+.3g} N mm about +z drive the shaft at {found.speed:.6g} rad/s at "
        f"its ball nuts and ball bearings; their friction torque {format_three_digits(1e3 * (found.torque or 0.0))} N mm"
    )
    return [("torque", text), left]


def _tables_of_shaft(found: Friction) -> list[Shown]:
    """Return the tables on the friction of the nuts and bearings of a shaft."""
    tables: list[Shown] = []
    if found.sets:
        tables.append(("ball nuts and ball bearings: friction of their contacts", SET_COLUMNS, found.sets))
    tables.append(("torque that turns the shaft", DRIVE_COLUMNS, () if found.drive is None else found.drive.sets))
    if found.roller_torques:
        title = "rows of tapered rollers: friction torque (from 0.03 to 0.15 of rib friction where none is given)"
        tables.append((title, ROLLER_COLUMNS, found.roller_torques))
    if len(found.over) > 1:
        tables.append(("over the coefficient of friction", OVER_COLUMNS_OF_SHAFT, found.over))
    return tables


# --- a screw over time


def torque_rows_over_angle(history: travel.TravelHistory) -> list[dict[str, object]]:
    """Return table rows of the friction torque over the angle of rotation, at most `ROWS`, evenly spaced."""
    which = np.unique(np.linspace(0, history.time.size - 1, min(ROWS, history.time.size)).round().astype(int))
    return [
        {
            "angle_deg": json_number(math.degrees(history.rotation_angle[k])),
            "torque_Nmm": json_number(1e3 * history.torque[k]),
            "groove_Nmm": json_number(1e3 * history.groove_torque[k]),
            "balls_Nmm": json_number(1e3 * (history.ball_torque[k] + history.closing_torque[k])),
            "loaded": int(history.loaded[k].sum()),
            "groups": int(history.touching_group_counts[k]),
        }
        for k in which
    ]


def lines_on_simulation(run: TransientRun) -> list[Line]:
    """Return terminal lines (label, text) on a simulation over time: torque, error due to the time steps, failures."""
    h, e = run.history, run.error
    if not h.begun_step_count:
        return [("run", run.status)]
    reached, asked = (f"{math.degrees(angle):.6g} deg" for angle in h.reached_and_intended_angle)
    far = f"over {reached}" if h.reached_end else f"stopped at {reached} of {asked},"
    digits = f".{digits_for_relative_error(None if e is None else e.largest_error)}g"
    t, parts_of_mean = h.torque_statistics, (h.groove_torque, h.ball_torque + h.closing_torque)
    values = t["mean"], t["least"], t["largest"], *(h.mean_over_time(part) for part in parts_of_mean)
    mean, least, most, groove, between = (format(json_number(1e3 * value), digits) for value in values)
    text = (
        f"{far} in {h.begun_step_count} steps: friction torque {mean} N mm in the mean, {least} to {most} N mm; "
        f"grooves {groove}, ball to ball {between} N mm in the mean"
    )
    lines = [("run", text)]
    if e is None:
        lines.append(("steps", f"error unknown, {why_no_step_error(run)}"))
    else:
        size = ", ".join(f"{100.0 * q.error:.2g} % in {QUANTITIES[name]}" for name, q in e.errors_by_quantity.items())
        order = e.errors_by_quantity["torque"].order
        seen = "no order observed" if math.isnan(order) else f"order {order:.2g} observed"
        text = (
            f"error of the time steps, as a part of the mean torque: {size}; from "
            f"{', '.join(map(str, e.step_counts))} steps ({seen}); goal {100.0 * run.allowed_error:g} %"
        )
        lines.append(("steps", text))
        if e.quantities_without_order:
            names = ", ".join(QUANTITIES[name] for name in e.quantities_without_order)
            text = (
                f"no order of convergence in {names}: the error is then taken as {travel.UNCLEAR:g} times the change "
                "between these numbers of steps"
            )
            lines.append(("", text))
    return lines if run.converged else [*lines, ("", run.status)]


def digits_for_relative_error(error: float | None) -> int:
    """Return how many significant digits of a value to show, from 3 to 6, so that at most two digits are uncertain.

    ``error``: relative error of the value; None if it is not known.
    """
    return 3 if error is None else int(np.clip(np.ceil(-np.log10(max(error, 1e-6))) + 2, 3, 6))


# --- single parts


def _line_on_energy_balance(found: Friction) -> Line:
    """Return a terminal line (label, text) on input power [W], friction loss [W] and their difference."""
    if not found.power_balance or not found.loss:
        return "energy", f"{found.loss:.6g} W are put in and lost"
    text = f"{found.input_power:.6g} W are put in and {found.loss:.6g} W lost, {found.power_balance:+.1e} W out of balance"
    return "energy", text


def _line_on_solver_residuals(loads: float, friction: float, suffix: str = "") -> Line:
    """Return a terminal line (label, text) on the unbalanced forces [N] of the contact loads and of friction."""
    return "solver", f"loads out of balance by {loads:.1e} N, friction by {friction:.1e} N{suffix}"


def _line_on_friction_law(found: parts.FrictionOfTwoBalls | parts.FrictionOfScrewRun) -> Line:
    """Return a terminal line on friction law, Hertz constants, and the effect of friction on contact loads."""
    return "law", f"coulomb, Hertz constants {found.hertz}, coupling of friction to loads: {found.coupling}"


def _lines_on_two_balls(found: parts.FrictionOfTwoBalls) -> list[Line]:
    """Return terminal lines (label, text) on two balls of a screw."""
    (pair,), rounds = found.pairs, f", {found.rounds} rounds"
    force = f"{pair.force:.6g} N from ball to ball, loss there {pair.loss:.6g} W"
    rise = "" if found.increase is None else f"; contact changes all losses by {found.increase:+.4g} %"
    return [
        ("force", force + rise),
        ("closing", f"when apart the balls close in at {pair.closing_apart:.6g} rad/s of azimuth"),
        _line_on_energy_balance(found),
        _line_on_solver_residuals(found.load_imbalance, found.friction_imbalance, rounds),
        _line_on_friction_law(found),
    ]


def _tables_of_two_balls(found: parts.FrictionOfTwoBalls) -> list[Shown]:
    """Return the table of two balls of a screw, apart and touching."""
    return [("per ball", PAIR_COLUMNS, found.balls)]


def _lines_on_linear_bearing(found: parts.FrictionOfLinearBearing) -> list[Line]:
    """Return terminal lines (label, text) on a row of balls in a linear bearing."""
    force = f"{found.carriage_force:.6g} N drive the carriage, {found.carriage_force_apart:.6g} N with the balls apart"
    rise = "" if found.increase is None else f": ball-to-ball contact changes it by {found.increase:+.4g} %"
    unbalanced = (
        f"loads out of balance by {found.load_imbalance:.1e} of the vertical force, friction by "
        f"{found.motion_residual:.1e} of its bound"
    )
    return [
        ("force", force + rise),
        ("states", found.second_state_words),
        _line_on_energy_balance(found),
        ("solver", unbalanced),
        ("law", f"coulomb, loads {found.distribution}; loads do not depend on friction"),
    ]


def _tables_of_linear_bearing(found: parts.FrictionOfLinearBearing) -> list[Shown]:
    """Return the tables of the balls of a linear bearing and of their contacts with each other."""
    return [("per ball", LINEAR_BALL_COLUMNS, found.balls), ("between balls", NEIGHBOUR_COLUMNS, found.pairs)]


def _lines_on_bearing_ball(found: parts.FrictionOfBearingBall) -> list[Line]:
    """Return terminal lines (label, text) on one ball of a bearing."""
    (ball,) = found.balls
    x, y, _ = ball.rotation or ()
    turn = f"{1e3 * (found.driving_torque_on_screw or 0.0):.6g} N mm turn the inner ring"
    by_loss = "" if found.torque is None else f" (dissipation over speed: {1e3 * found.torque:.6g} N mm)"
    return [
        ("torque", turn + by_loss),
        ("loads", f"sum of contact loads {found.load_sum:.6g} N; they do not depend on friction"),
        ("ball", f"orbit {ball.orbit:.6g} rad/s, omega_x {x:.6g} rad/s, omega_y {y:.6g} rad/s"),
        _line_on_energy_balance(found),
        _line_on_solver_residuals(found.load_imbalance, found.friction_imbalance),
        ("law", f"{found.law}, Hertz constants {found.hertz}"),
    ]


def _tables_of_bearing_ball(found: parts.FrictionOfBearingBall) -> list[Shown]:
    """Return the table of the loaded contacts of one ball of a bearing."""
    (ball,) = found.balls
    known = {key: quantity_value(ball, key) for key, *_ in CONTACT_COLUMNS if key in ball.keys}
    slide, along = quantity_value(ball, "sliding_mm_s"), quantity_value(ball, "friction_N")
    rows = [
        {"side": side, "slide": slide[side][1], "along": along[side][1]} | {key: of[side] for key, of in known.items()}
        for side in bearing.SIDES
        if (ball.load[side] or 0.0) > 0.0
    ]
    return [("per contact", CONTACT_COLUMNS, rows)]


def _lines_on_two_bearings(found: parts.FrictionOfTwoBearings) -> list[Line]:
    """Return terminal lines (label, text) on two bearings over the angle of the load."""
    assert found.four_point is not None
    assert found.double_row is not None
    four, double = (format_cell(one.variation, ".5g") for one in (found.four_point, found.double_row))
    label, text = _line_on_energy_balance(found)
    ring = "free to tilt" if found.tilt else "kept from tilting"
    return [
        ("torque", f"largest over smallest: four-point {four}, double row {double}"),
        (label, f"{text}, mean over the angles"),
        ("solver", f"loads out of balance by {found.load_imbalance:.1e} N"),
        ("law", f"coulomb, Hertz constants {found.hertz}, inner ring {ring}"),
    ]


def _tables_of_two_bearings(found: parts.FrictionOfTwoBearings) -> list[Shown]:
    """Return the table of the friction torques of two bearings over the angle of the load."""
    four, double = found.four_point, found.double_row
    if four is None or double is None:
        return []
    columns = zip(
        np.degrees(found.load_angle),
        *([1e3 * torque for torque in one.torque] for one in (four, double)),
        found.ratio,
        four.beyond,
        (f and d for f, d in zip(four.converged, double.converged, strict=True)),
        strict=True,
    )
    keys = [key for key, *_ in BEARING_COLUMNS]
    return [("over the load's angle", BEARING_COLUMNS, [dict(zip(keys, row, strict=True)) for row in columns])]


def _lines_on_screw_run(found: parts.FrictionOfScrewRun) -> list[Line]:
    """Return terminal lines (label, text) on a screw over time."""
    run, (label, text) = found.over_time, _line_on_energy_balance(found)
    largest, failed = found.largest_imbalance, int(np.sum(~run.history.converged))
    return [
        *lines_on_simulation(run),
        ("balls", f"{found.ball_count} over {found.duration:.6g} s"),
        (label, f"{text}, at most {largest:.1e} of the loss out of balance at an instant" if largest else text),
        ("solver", f"{failed} of {run.history.time.size} instants failed"),
        _line_on_friction_law(found),
    ]


def _tables_of_screw_run(found: parts.FrictionOfScrewRun) -> list[Shown]:
    """Return the table on contacts between balls and mean torques of a screw over time."""
    of = found.summary
    shown = [{"quantity": label, "value": format_cell(quantity_value(of, key), form)} for key, label, form in RUN_LINES]
    return [("summary", RUN_COLUMNS, shown)]


#: Functions that return the lines, then the tables, of each record of single parts.
OF_PARTS: dict[type[Friction], tuple[Callable[[Any], list[Line]], Callable[[Any], list[Shown]]]] = {
    parts.FrictionOfTwoBalls: (_lines_on_two_balls, _tables_of_two_balls),
    parts.FrictionOfLinearBearing: (_lines_on_linear_bearing, _tables_of_linear_bearing),
    parts.FrictionOfBearingBall: (_lines_on_bearing_ball, _tables_of_bearing_ball),
    parts.FrictionOfTwoBearings: (_lines_on_two_bearings, _tables_of_two_bearings),
    parts.FrictionOfScrewRun: (_lines_on_screw_run, _tables_of_screw_run),
}
