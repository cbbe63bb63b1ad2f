"""Bearings in makers' catalogues: printed preload, rigidity, clearance and ratings, compared with computed ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from math import cos, pi, radians

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from rollbench.compare.cases.makers import outside
from rollbench.compare.scenes import catalogue, makers
from rollbench.lowfi.bearings import angular_contact
from rollbench.lowfi.bearings.axis import HertzPowerLawRow, equal_rows_with_gap, solve_bearing_row_equilibrium
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import ARRANGEMENTS
from rollbench.meshes.parts import Scene

#: Young's modulus [Pa], Poisson's ratio and conformity (groove radius over ball diameter) assumed for ratings (ISO 281,
#: ISO 76): makers do not print them.
YOUNG, POISSON, CONFORMITY = 207e9, 0.3, 0.52

#: Exponent n of starting torque ~ load^n of a bearing row: major semi-axis times load (Palmgren; Smith 2.33).
TORQUE = 4.0 / 3.0


# --- bearing sets (DB, DBD, ...) with equal gaps


@cache
def bearing_set_over_pair_ratios(name: str) -> tuple[float, float, float]:
    """Return preload, rigidity and starting torque of a group of matched bearings, divided by those of a back-to-back pair.

    The rigidity is the tangent rigidity. ``name``: arrangement of the bearings, such as "DBD" (the pair is "DB"). The
    contact angle is constant; clamping closes an equal gap between the rings of each bearing.
    """
    one = HertzPowerLawRow()

    def preload_rigidity_and_torque_of_set(name: str) -> Array:
        """Return preload, tangent rigidity, starting torque (3,) of the arrangement ``name``, in arbitrary units."""
        rows = tuple(1 if way == "+z" else -1 for way in ARRANGEMENTS[name])
        state = solve_bearing_row_equilibrium(equal_rows_with_gap(one, rows, 1e-6))
        loads = state.row_thrusts
        return np.array([loads[np.array(rows) == 1].sum(), state.stiffness, (loads**TORQUE).sum()])

    preload, rigidity, torque = preload_rigidity_and_torque_of_set(name) / preload_rigidity_and_torque_of_set("DB")
    return float(preload), float(rigidity), float(torque)


#: Quantities of a bearing set: name, column in the table, unit, exponent over the preload at a constant contact angle.
SET_QUANTITIES = (
    ("preload", "preload_N", "N", 1.0),
    ("rigidity", "rigidity_N_per_um", "N/um", 1.0 / 3.0),
    ("torque", "starting_torque_N_m", "N m", TORQUE),
)


def compare_nsk_bearing_sets() -> Iterator[outside.PublishedValue]:
    """Yield printed preload, rigidity and starting torque of NSK's bearing sets, with values from back-to-back pairs.

    The computed value of a set is the printed value of the pair times the computed ratio of set to pair. The computed value
    of a pair of preload class C9 is the printed value of the pair of class C10, converted to the preload of C9.
    """
    for source in makers.read_maker_tables("nsk-tac"):
        named = dict(entry.split("=") for entry in source.header["sets"].split("; "))
        pairs = {(r["bearing"], r["preload_class"]): r for r in source.rows if named[r["arrangement"]] == "DB"}
        for row in source.rows:
            name, cls = named[row["arrangement"]], row["preload_class"]
            kind = name if name != "DB" else "class"
            if kind == "class" and cls != "C9":
                continue
            pair = pairs[row["bearing"], cls if kind != "class" else "C10"]
            growth = source.parse_number(row["preload_N"]) / source.parse_number(pair["preload_N"])
            ratios = bearing_set_over_pair_ratios(name)
            if kind == "class":
                ratios = tuple(growth**power for *_, power in SET_QUANTITIES)
            for (quantity, column, unit, power), ratio in zip(SET_QUANTITIES, ratios, strict=True):
                if kind == "class" and quantity == "preload":
                    continue
                half = 0.5 * float(source.header.get(f"{quantity}_step_{cls}", "0"))
                base = source.parse_number(pair[column])
                off = max(makers.half_step_of_last_digit(pair[column]), half) / base
                if kind == "class":
                    off += power * sum(source.relative_rounding(r["preload_N"]) for r in (row, pair))
                what = (quantity, "sets and preloads from one pair", f"{row['bearing']} {cls} {name}", unit)
                rounding = max(makers.half_step_of_last_digit(row[column]), half)
                band = outside.ComputedBand.from_relative_half_width(ratio * base, off)
                yield outside.value_of_table_entry(source, row, "line", column, what, band, rounding=rounding)


# --- bearings from their ratings


@cache
def _nine_ball_bearing_with_iso_material() -> Scene:
    """Return the shipped scene of a nine-ball bearing, with the elastic constants assumed for ISO 281 and ISO 76."""
    found = catalogue.scene("bearing-9")
    material = replace(found.nut.material, youngs_modulus=YOUNG, poissons_ratio=POISSON)
    balls = replace(found.balls, material=material)
    screw, nut = replace(found.screw, material=material), replace(found.nut, material=material)
    return replace(found, screw=screw, nut=nut, balls=balls)


def single_row_bearing_scene(
    ball_count: int, ball_diameter: float, pitch: float, angle: float, conformity: float = CONFORMITY
) -> Scene:
    """Return the scene of a single-row ball bearing with given dimensions.

    ``ball_count``: number of balls; ``ball_diameter``, ``pitch``: diameters of ball and pitch circle [m]; ``angle``:
    contact angle [rad]; ``conformity``: groove radius over ball diameter, the same on both rings.
    """
    one = _nine_ball_bearing_with_iso_material()
    groove = conformity * ball_diameter
    return replace(
        one,
        track=replace(one.track, pitch_radius=0.5 * pitch, contact_angle=angle),
        screw=replace(one.screw, groove_radius=groove),
        nut=replace(one.nut, groove_radius=groove),
        balls=replace(one.balls, radius=0.5 * ball_diameter, azimuths=tuple(2.0 * pi * np.arange(ball_count) / ball_count)),
    )


#: Number of balls and pitch diameter [m] at which ratings are computed, and ball over pitch diameters between which they
#: are interpolated: C goes with Z^(2/3) D^1.8, C_0 with Z D^2, and both with a smooth function of D over d_m.
FEW, PITCH, RELATIVE = 10, 0.1, np.linspace(0.03, 0.36, 23)


@cache
def rating_factor_splines(angle: float) -> tuple[CubicSpline, CubicSpline]:
    """Return the factors of a bearing's load ratings by ISO 281 and ISO 76, as splines over D/d_m.

    First: C/(Z^(2/3) D^1.8) of the dynamic rating C; second: C_0/(Z D^2) of the static rating C_0, in N and m. Z: number
    of balls; D: ball diameter; d_m: pitch diameter; ``angle``: contact angle [rad].
    """
    rings = [single_row_bearing_scene(FEW, x * PITCH, PITCH, angle) for x in RELATIVE]
    balls = RELATIVE * PITCH
    dynamic = [dynamic_rating(one) for one in rings] / (FEW ** (2.0 / 3.0) * balls**1.8)
    static = [static_rating(one) for one in rings] / (FEW * balls**2)
    return CubicSpline(RELATIVE, dynamic), CubicSpline(RELATIVE, static)


def ball_count_and_diameter_from_ratings(dynamic: float, static: float, pitch: float, angle: float) -> tuple[float, float]:
    """Return the number of balls (not rounded), then their diameter [m], that give a bearing's load ratings.

    ISO 281 and ISO 76 are inverted. ``dynamic``, ``static``: ratings C and C_0 [N]; ``pitch``: pitch diameter [m];
    ``angle``: contact angle [rad].
    """
    of_dynamic, of_static = rating_factor_splines(angle)

    def ball_count_for_static_rating(ball: float) -> float:
        """Return the number of balls of diameter ``ball`` [m], not rounded, that gives the static rating C_0."""
        return static / (float(of_static(ball / pitch)) * ball**2)

    def dynamic_rating_error(ball: float) -> float:
        """Return the relative error of the dynamic rating, if balls of diameter ``ball`` [m] give the static rating."""
        computed = float(of_dynamic(ball / pitch)) * ball_count_for_static_rating(ball) ** (2.0 / 3.0) * ball**1.8
        return float(computed / dynamic - 1.0)

    low, high = float(RELATIVE[0]), float(RELATIVE[-1])
    ball = float(brentq(dynamic_rating_error, low * pitch, high * pitch, rtol=1e-9))
    return ball_count_for_static_rating(ball), ball


def _mean_of_bore_and_outer_diameter(row: Mapping[str, str]) -> float:
    """Return the mean of bore and outside diameter [m] of a bearing, which is taken for its pitch diameter.

    ``row``: texts of the bearing's row in the catalogue, by column.
    """
    return 0.5e-3 * (float(row["bore_mm"]) + float(row["outside_diameter_mm"]))


def compare_nsk_ball_bearings() -> Iterator[outside.PublishedValue]:
    """Yield NSK's printed axial clearance, rigidity and factor f_0 of ball bearings, with computed values.

    Number and diameter of the balls follow from the printed ratings, the conformity from the rigidity at the highest
    preload. The axial clearance of a preloaded pair is 2 (u(measuring load) - u(preload)), with u the displacement of one
    row under a thrust. Contact angles change under load.
    """
    source = makers.read_maker_table("nsk-angular")
    groups: dict[str, list[Mapping[str, str]]] = {}
    for row in source.rows:
        groups.setdefault(row["bearing"], []).append(row)
    bearings = list(groups.values())

    def column_values(key: str) -> Array:
        """Return a column of NSK's table as an array of numbers, (bearings, preloads); ``key``: name of the column."""
        return np.array([[source.parse_number(row[key]) for row in rows] for rows in bearings])

    pitch = np.array([_mean_of_bore_and_outer_diameter(rows[0]) for rows in bearings])
    angle = np.radians(column_values("angle_deg")[:, 0])
    dynamic, static = (1e3 * column_values(key)[:, 0] for key in ("Cr_kN", "C0r_kN"))
    ratings = zip(dynamic, static, pitch, angle, strict=True)
    count, ball = np.array([ball_count_and_diameter_from_ratings(*of) for of in ratings]).T
    grooves = (CONFORMITY,) * 2
    begin = angular_contact.bearing_with_contact_angle(np.round(count), ball, pitch, grooves, angle, YOUNG, POISSON)
    forces, rigid, load = column_values("preload_N"), column_values("rigidity_N_per_um"), column_values("measuring_load_N")
    step = np.array([makers.half_step_of_last_digit(rows[-1]["rigidity_N_per_um"]) for rows in bearings])
    moved, stiff = [], []
    for off in (0.0, step, -step):
        conformity = angular_contact.conformity_from_pair_rigidity(begin, forces[:, -1], 1e6 * (rigid[:, -1] + off))
        balls, balls_size, circle, groove, rest = (x[:, None] for x in (begin.balls, ball, pitch, conformity, angle))
        each = angular_contact.bearing_with_contact_angle(balls, balls_size, circle, (groove,) * 2, rest, YOUNG, POISSON)
        state = angular_contact.bearing_states_under_thrust(each, np.column_stack([forces, load[:, -1]]))
        moved.append(1e6 * state.displacement)
        stiff.append(2e-6 * state.stiffness[:, :-1])
    for i, rows in enumerate(bearings):
        yield from _compare_clearances_and_rigidities(source, rows, forces[i], np.array(moved)[:, i], np.array(stiff)[:, i])
        if rows[0]["f0"][:1].isdigit():
            factor = 1e-6 * static[i] / (count[i] * ball[i] ** 2 * cos(angle[i]))
            yield _published_factor_f0(source, rows[0], float(factor))


def _compare_clearances_and_rigidities(
    source: makers.MakerTable, rows: list[Mapping[str, str]], preloads: Array, displacements_um: Array, rigidities: Array
) -> Iterator[outside.PublishedValue]:
    """Yield the printed axial clearances and rigidities of one bearing at p preloads, with computed values.

    ``source``: the maker's table; ``rows``: its rows, one for each preload; ``preloads``: preloads (p,) [N];
    ``displacements_um``: displacements (3, p + 1) [um] at the preloads and at the measuring load; ``rigidities``:
    rigidities (3, p) [N/um]. Both have three rows: computed from the printed rigidity at the highest preload, and from the
    smallest and the largest rigidity that round to this printed value.
    """
    clearance = 2.0 * (displacements_um[:, -1:] - displacements_um[:, :-1])
    for i, row in enumerate(rows):
        share = makers.half_step_of_last_digit(row["preload_N"]) / preloads[i]
        item, law = f"{row['bearing']} {row['preload_class']}", "bearing whose angle turns"
        what, scale = ("displacement", law, item, "um"), float(2.0 * displacements_um[0, -1])
        band = outside.ComputedBand.from_values(clearance[:, i], 4.0 / 3.0 * displacements_um[0, i] * share)
        number = source, row, "line_clearance", "clearance_um"
        yield outside.value_of_table_entry(*number, what, band, rounding=0.5, scale=scale)
        what, left = ("rigidity", law, item, "N/um"), "the conformity is taken from it" if row is rows[-1] else ""
        band = outside.ComputedBand.from_values(rigidities[:, i], rigidities[0, i] * share / 3.0)
        yield outside.value_of_table_entry(source, row, "line_preload", "rigidity_N_per_um", what, band, left=left)


def _published_factor_f0(source: makers.MakerTable, row: Mapping[str, str], factor: float) -> outside.PublishedValue:
    """Return the printed factor f_0 = C_0/(Z D^2 cos alpha) of a bearing together with the computed value.

    ``source``: the maker's table; ``row``: texts of the bearing's row, by column; ``factor``: the computed value
    [N/mm^2], with number Z and diameter D of the balls that follow from the printed ratings.
    """
    off = factor * sum(source.relative_rounding(row[key]) for key in ("Cr_kN", "C0r_kN"))
    what = ("rating", "ISO 281 and ISO 76", f"{row['bearing']} f0", "")
    band = outside.ComputedBand.from_values((factor,), off)
    return outside.value_of_table_entry(source, row, "line_product", "f0", what, band)


def compare_snfa_pair_rigidities() -> Iterator[outside.PublishedValue]:
    """Yield SNFA's printed rigidities of preloaded bearing pairs, with values for contact angles that change under load.

    The printed values follow the catalogue's formula for a constant contact angle, so they are shown but not judged.
    """
    source = makers.read_maker_table("snfa-angular")

    def column_values(key: str, factor: float = 1.0) -> Array:
        """Return a column of SNFA's table as an array of numbers, times ``factor``; ``key``: name of the column."""
        return factor * np.array([source.parse_number(row[key]) for row in source.rows])

    pitch, angle = [_mean_of_bore_and_outer_diameter(row) for row in source.rows], np.radians(column_values("angle_deg"))
    balls, size = column_values("balls"), column_values("ball_diameter_mm", 1e-3)
    grooves = (CONFORMITY,) * 2
    rows = angular_contact.bearing_with_contact_angle(balls, size, np.array(pitch), grooves, angle, YOUNG, POISSON)
    stiff = 2e-7 * angular_contact.bearing_states_under_thrust(rows, column_values("preload_daN", 10.0)).stiffness
    for row, found in zip(source.rows, stiff, strict=True):
        item = f"{row['bearing']} {row['angle_deg']} deg {row['preload_class']}"
        what, left = ("rigidity", "bearing whose angle turns", item, "daN/um"), "a formula in disguise"
        band = outside.ComputedBand.from_values((found,))
        yield outside.value_of_table_entry(source, row, "line_preload", "Ra_pair_daN_per_um", what, band, left=left)


def compare_snfa_load_ratings() -> Iterator[outside.PublishedValue]:
    """Yield SNFA's printed load ratings C and C_0, each with the value by ISO 281 or ISO 76 for the printed balls.

    The range (band) of the computed values covers pitch diameters within 2 % of the mean of bore and outside diameter, and
    the rounding of the printed ball diameter.
    """
    source, done = makers.read_maker_table("snfa-angular"), set[tuple[str, str]]()
    for row in source.rows:
        if (row["bearing"], row["C33_daN"]) in done:
            continue
        done.add((row["bearing"], row["C33_daN"]))
        ball, count, x = 1e-3 * float(row["ball_diameter_mm"]), int(row["balls"]), 1.0 / np.array([1.0, 0.98, 1.02])
        off = 2.0 * makers.half_step_of_last_digit(row["ball_diameter_mm"]) / float(row["ball_diameter_mm"])
        of_dynamic, of_static = rating_factor_splines(radians(float(row["angle_deg"])))
        x *= ball / _mean_of_bore_and_outer_diameter(row)
        maker = f"{source.header['maker']}, series {'VE' if row['bearing'].startswith('VE') else 'S, E'}"
        for column, found in (
            ("C33_daN", 0.1 * of_dynamic(x) * count ** (2.0 / 3.0) * ball**1.8),
            ("C0_daN", 0.1 * of_static(x) * count * ball**2),
        ):
            what = ("rating", "ISO 281 and ISO 76", f"{row['bearing']} {column.partition('_')[0]}", "daN")
            band = outside.ComputedBand.from_values(found, off * float(found[0]))
            yield outside.value_of_table_entry(source, row, "line_product", column, what, band, maker=maker)
