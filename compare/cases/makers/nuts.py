"""Ball nuts in makers' catalogues: printed load ratings, rigidities and drag torques against computed values.

The drag torque of a preloaded nut is computed from the sliding of its balls, and compared with the makers' formulas and
with measurements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import pi, prod, radians, sqrt
from typing import Any

import numpy as np

from rollbench.compare.cases.makers import outside
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue, makers
from rollbench.compare.scenes.from_keys import angle_of_touching_balls, ball_oversize_for_preload
from rollbench.compare.scenes.template import BEYOND, STOCK, WALL
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.lowfi.rating.rigidity import PRACTICE, approach_per_displacement, axial_compliance_of_bodies
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.parts import BallErrors, Friction, Load, Motion, Scene, Support

#: Conformity (groove radius over ball diameter): usual value and range; contact angle [deg]. Makers do not print them.
CONFORMITY, CONFORMITIES, ANGLE = 0.5225, (0.515, 0.53), 45.0

#: Fraction of the turns that is filled with balls, lowest and highest: for circuits of several turns (LONG), and of one
#: turn (SHORT), whose deflector may take a third of it.
LONG, SHORT = (0.9, 1.0), (0.65, 1.0)

#: Columns of Rexroth's table with the dimensions of a nut: ball diameter, nominal diameter and lead.
DIMENSIONS = ("ball_diameter_mm", "nominal_diameter_mm", "lead_mm")

#: Axial load under which rigidity is computed, and preload of THK's preloaded nuts, both divided by the dynamic rating C.
LOADED, PRELOADED = 0.3, 0.1

#: Axial load over preload at which one nut of a preloaded pair becomes loose; the rigidity is the secant up to this load.
LIFT = 2.0**1.5


@dataclass(frozen=True)
class CatalogueNut:
    """Dimensions of a ball nut in a catalogue.

    ``ball_diameter``, ``pitch_diameter``: diameters of ball and pitch circle [m]; ``lead``: lead of the screw [m];
    ``turns``: number of loaded turns, summed over all circuits; ``has_one_turn_circuits``: whether each ball circuit has
    one turn only, of which the deflector takes a part.
    """

    ball_diameter: float
    pitch_diameter: float
    lead: float
    turns: float
    has_one_turn_circuits: bool

    @property
    def touching_balls_per_turn(self) -> float:
        """Number of balls in one full turn if each ball touches the next one; in general not a whole number."""
        return float(2.0 * pi / angle_of_touching_balls(0.5 * self.pitch_diameter, self.lead, self.ball_diameter))

    @property
    def filled_fraction_range(self) -> tuple[float, float]:
        """Lowest and highest fraction of the loaded turns' length that balls fill in nuts of this kind."""
        return SHORT if self.has_one_turn_circuits else LONG


def scene_of_one_loaded_turn(nut: CatalogueNut, conformity: float) -> Scene:
    """Return the scene of a screw and nut with one loaded turn, whose balls touch each other.

    ``conformity``: groove radius over ball diameter.
    """
    one, groove = catalogue.scene("unseen-40x10"), conformity * nut.ball_diameter
    balls = max(1, round(nut.touching_balls_per_turn))
    nut_diameter = nut.pitch_diameter + (1.0 + 2.0 * WALL) * nut.ball_diameter
    screw_diameter, path = nut.pitch_diameter - 2.0 * BEYOND * nut.ball_diameter, 0.5 * nut.pitch_diameter
    return replace(
        one,
        track=replace(one.track, pitch_radius=path, lead=nut.lead, contact_angle=radians(ANGLE), starts=1),
        screw=replace(one.screw, groove_radius=groove, outer_diameter=screw_diameter, bore=0.0),
        nut=replace(one.nut, groove_radius=groove, outer_diameter=nut_diameter),
        balls=replace(one.balls, radius=0.5 * nut.ball_diameter, azimuths=tuple(2.0 * pi * np.arange(balls) / balls)),
    )


def nut_load_ratings(nut: CatalogueNut, conformity: float, filled_fraction: float) -> tuple[float, float]:
    """Return the dynamic rating C, then the static rating C_0 of a nut [N] by ISO 3408-5.

    ``conformity``: groove radius over ball diameter; ``filled_fraction``: fraction of the turns that is filled with balls.
    """
    one = scene_of_one_loaded_turn(nut, conformity)
    share = filled_fraction * nut.touching_balls_per_turn / one.ball_count
    return dynamic_rating(one) * share ** (2.0 / 3.0) * nut.turns**0.86, static_rating(one) * share * nut.turns


def nut_displacement(
    nut: CatalogueNut, conformity: float, filled_fraction: float, load: float, *, with_elastic_bodies: bool = True
) -> float:
    """Return the axial displacement [m] of a nut without preload, all balls loaded equally.

    ``conformity``: groove radius over ball diameter; ``filled_fraction``: fraction of the turns that is filled with balls;
    ``load``: axial load [N]; ``with_elastic_bodies``: whether the radial deformation of nut and screw (as thick tubes) is
    added to the deformation of the Hertz contacts.
    """
    one = scene_of_one_loaded_turn(nut, conformity)
    constants, slope = hertz_without_errors(one).C, approach_per_displacement(one)
    each = load / (filled_fraction * nut.touching_balls_per_turn * nut.turns * slope)
    tubes = (axial_compliance_of_bodies(one) or 0.0) / nut.turns if with_elastic_bodies else 0.0
    return float((constants[0] + constants[3]) * np.cbrt(each) ** 2 / slope + tubes * load)


# --- dimensions from catalogue entries


def nut_of_catalogue_row(source: makers.MakerTable, row: Mapping[str, str]) -> CatalogueNut:
    """Return the dimensions of a nut from its row in a catalogue.

    ``source``: table of the catalogue; ``row``: texts of the nut's row, by column. Diameters that are not printed are
    assumed: see `makers.ball_and_pitch_diameter`.
    """
    ball, pitch = makers.ball_and_pitch_diameter(source, row)
    circuits = makers.read_circuits(row)
    short = circuits.turns == 1.0 and not circuits.on_starts
    lead = 1e-3 * source.parse_number(row["lead_mm"])
    return CatalogueNut(1e-3 * ball, 1e-3 * pitch, lead, circuits.number * circuits.turns, short)


def maker_and_rated_nut_type(source: makers.MakerTable, row: Mapping[str, str]) -> str:
    """Return the maker's name, with the type of nut if this maker rates several types by different rules.

    ``source``: table of the maker; ``row``: texts of the nut's row, by column.
    """
    maker = source.header["maker"]
    if maker == "HIWIN":
        return f"{maker}, " + ("whole" if row["turns"].startswith("K") else "one-turn") + " recirculation"
    if maker == "THK":
        return f"{maker}, " + ("without preload" if row["type"] == "single nut" else "preloaded")
    return "TBI, Wangong" if maker in ("TBI", "Wangong") else maker  # whose tables of one series are one


# --- comparisons with printed values


def compare_nut_ratings() -> Iterator[outside.PublishedValue]:
    """Yield printed load ratings C and C_0 of nuts, each with the value by ISO 3408-5.

    Only nuts whose ball diameter is printed are compared. The computed values have a range (band) over the usual
    conformities and fractions of turns that are filled with balls.
    """
    for source in makers.read_maker_tables("nuts-"):
        for row in source.rows:
            if not row["ball_mm"]:
                continue
            nut, unit = nut_of_catalogue_row(source, row), source.unit_factor("load_unit")
            filled = nut.filled_fraction_range
            corners = [(CONFORMITY, 0.5 * sum(filled))] + [(c, x) for c in CONFORMITIES for x in filled]
            found = np.array([nut_load_ratings(nut, *corner) for corner in corners]) / unit
            for k, key in enumerate(("C", "C0")):
                what = ("rating", "ISO 3408-5", f"{row['nut']} {key}", source.header["load_unit"])
                band, maker = outside.ComputedBand.from_values(found[:, k]), maker_and_rated_nut_type(source, row)
                yield outside.value_of_table_entry(source, row, "line", key, what, band, maker=maker)


def secant_rigidity(nut: CatalogueNut, conformity: float, filled_fraction: float, load: float, preload: float) -> float:
    """Return the axial rigidity [N/m] of a nut with elastic bodies between ``preload`` and ``load`` [N]."""
    start = nut_displacement(nut, conformity, filled_fraction, preload) if preload else 0.0
    return load / (nut_displacement(nut, conformity, filled_fraction, load) - start)


def compare_nut_rigidity() -> Iterator[outside.PublishedValue]:
    """Yield printed rigidities of nuts, each with the computed value.

    A rigidity is the axial load 0.3 C (C: dynamic rating) over the nut's displacement from zero load to 0.3 C; for
    preloaded nuts, over the displacement from 0.1 C to 0.3 C. The computed rigidity has the deformations of Hertz contacts
    and thick tubes. The number of balls follows from the printed static rating C_0, so that the band of computed values
    only covers the range of conformity and 5 % more or fewer balls.
    """
    for source in makers.read_maker_tables("nuts-"):
        for row in source.rows:
            if not row.get("rigidity"):
                continue
            nut, unit = nut_of_catalogue_row(source, row), source.unit_factor("load_unit")
            load = LOADED * source.parse_number(row["C"]) * unit
            share = source.parse_number(row["C0"]) * unit / nut_load_ratings(nut, CONFORMITY, 1.0)[1]  # of balls, by C_0
            preload = PRELOADED / LOADED * load if row["type"] in source.header.get("preloaded", "-").split(", ") else 0.0

            stiff = source.unit_factor("rigidity_unit")
            corners = [(CONFORMITY, share)] + [(c, x * share) for c in CONFORMITIES for x in (0.95, 1.05)]
            rigidities = [secant_rigidity(nut, *corner, load, preload) / stiff for corner in corners]
            band = outside.ComputedBand.from_values(rigidities)
            what = ("rigidity", "contacts and tubes under 0.3 C", row["nut"], source.header["rigidity_unit"])
            maker, practice = maker_and_rated_nut_type(source, row), PRACTICE * band.value
            yield outside.value_of_table_entry(source, row, "line", "rigidity", what, band, maker=maker, practice=practice)


def _nut_of_rexroth_row(source: makers.MakerTable, row: Mapping[str, str]) -> CatalogueNut:
    """Return the dimensions of a preloaded nut from its row in Rexroth's table of preloads."""
    turns = prod(map(float, row["turns"].replace(",", ".").split("x")))
    ball, outer, lead = (1e-3 * source.parse_number(row[k]) for k in DIMENSIONS)
    return CatalogueNut(ball, outer + 2.0 * BEYOND * ball, lead, turns, has_one_turn_circuits=False)


def compare_preloaded_nuts() -> Iterator[outside.PublishedValue]:
    """Yield Rexroth's printed rigidities of preloaded nuts at several preloads, each with the computed value.

    At the highest preload, the rigidity is computed from contacts and tubes. At the other preloads, the computed value is
    the printed rigidity at the highest preload times the cube root of the ratio of the preloads.
    """
    source = makers.read_maker_table("rexroth-preload")
    groups: dict[tuple[str, str], list[Mapping[str, str]]] = {}
    for row in source.rows:
        groups.setdefault((row["nut_kind"], row["size"]), []).append(row)
    for (kind, size), rows in groups.items():
        nut = _nut_of_rexroth_row(source, rows[0])
        ordered = sorted(rows, key=lambda row: source.parse_number(row["preload_percent_of_C"]))
        top = ordered[-1]
        for row in ordered:
            share = source.parse_number(row["preload_percent_of_C"])
            preload = 0.01 * share * source.parse_number(row["C_N"])
            if row is top:
                ends = [
                    1e-6 * LIFT * preload / nut_displacement(nut, c, x, preload, with_elastic_bodies=bodies)
                    for c, x, bodies in ((CONFORMITY, 0.95, True), (0.515, 1.0, False), (0.53, 0.9, True))
                ]
                law, practice = "contacts and tubes, both nuts loaded", PRACTICE * ends[0]
            else:
                highest = top["Rnu_N_per_um"]
                base, step = source.parse_number(highest), makers.half_step_of_last_digit(highest)
                growth = np.cbrt(share / source.parse_number(top["preload_percent_of_C"]))
                ends, law, practice = [x * growth for x in (base, base + step, base - step)], "growth with preload", None
            what = ("rigidity", law, f"{kind} {size}, {share:g} % of C", "N/um")
            band = outside.ComputedBand.from_values(ends)
            yield outside.value_of_table_entry(source, row, "line_values", "Rnu_N_per_um", what, band, practice=practice)


#: Coefficient of sliding friction of balls on grooves: the largest and the smallest value of lubricated contacts.
DEFAULT, LEAST = 0.1, 0.03

#: Name of the friction model in the tables.
SLIDING = "sliding of the balls, coefficient 0.1"

#: Number of balls that are computed instead of all balls of a nut.
FEW = 8


def _screw_with_eight_balls(nut: CatalogueNut) -> Scene:
    """Return the scene of a nut with one turn and only 8 balls (`FEW`), on a screw that is supported at both ends."""
    one = scene_of_one_loaded_turn(nut, CONFORMITY)
    ends = (("ux", "uy", "rx", "ry", "rz"), ("ux", "uy"))
    at = (0.0, one.screw.length)
    return replace(
        one,
        balls=replace(one.balls, azimuths=tuple(2.0 * pi * np.arange(FEW) / FEW)),
        errors=replace(one.errors, balls=BallErrors()),
        supports=tuple(Support(z, tuple((f, 0.0) for f in held)) for z, held in zip(at, ends, strict=True)),
        loads=(),
    )


@cache
def drag_torque_of_ball(nut: CatalogueNut, axial_force_on_ball: float, coefficient: float, *, double: bool) -> float:
    """Return the drag torque [N m] of one ball of a preloaded nut, or of two balls of a double nut, one in each nut.

    ``axial_force_on_ball``: axial force [N] that the preload exerts on the ball; ``coefficient``: coefficient of friction;
    ``double``: whether the nut is double, so that its balls are loaded on two flanks. In a single nut, oversize balls are
    loaded on four flanks.
    """
    scene = _screw_with_eight_balls(nut)
    if double:
        loaded = replace(scene, loads=(Load(0.0, (0.0, 0.0, axial_force_on_ball * FEW)),))
    else:
        size = BallErrors(oversize=ball_oversize_for_preload(scene, axial_force_on_ball * FEW))
        loaded = replace(scene, errors=replace(scene.errors, balls=size))
    found = run_model(loaded, "lin", ModelOptions(estimate_beam_mesh_error=False))
    state = friction_state(loaded, found, Friction(coefficient, coefficient), Motion(2.0 * pi))
    torque = state.friction_sums.friction_torque
    return (2.0 if double else 1.0) * torque / FEW


def drag_torque_of_nut(nut: CatalogueNut, preload: float, coefficient: float = DEFAULT, *, double: bool = False) -> float:
    """Return the drag torque [N m] of a nut under an axial preload [N], with all turns filled with balls.

    ``coefficient``: coefficient of friction; ``double``: True for a double nut, whose balls are loaded on two flanks; False
    for a single nut with oversize balls, which are loaded on four flanks.
    """
    balls = nut.touching_balls_per_turn * nut.turns
    return balls * drag_torque_of_ball(nut, preload / balls, coefficient, double=double)


# --- makers' formulas for the drag torque T over preload F [N], nominal diameter d_0 and lead P [m]


#: Drag torque T [N m] as a function of preload F [N], nominal diameter d_0 [m] and lead P [m], by the name of the formula:
#: that behind Rexroth's table of single nuts; that of THK and JIS B 1192, with tan beta = P/(pi d_0); that of HIWIN with
#: K_p = 0.2, the middle of the stated range.
FORMULAS: dict[str, Callable[[float, float, float], float]] = {
    "Rexroth: 0.0100 F d0": lambda preload, diameter, _: 0.01 * preload * diameter,
    "THK: 0.05/sqrt(tan beta) F P/2 pi": lambda preload, diameter, lead: (
        0.05 / sqrt(lead / (pi * diameter)) * preload * lead / (2.0 * pi)
    ),
    "HIWIN: 0.2 F P/2 pi": lambda preload, _, lead: 0.2 * preload * lead / (2.0 * pi),
}

#: Nominal diameter and leads [mm] at which formulas are compared; diameter of the ball [mm]; axial force on a ball [N].
SWEPT, BALL, SHARE = (32.0, (8.0, 10.0, 16.0, 20.0, 32.0)), 4.763, 60.0


def nut_for_drag_comparison(lead: float) -> CatalogueNut:
    """Return the nut for which the makers' drag-torque formulas are compared: one turn, and a given lead [m]."""
    return CatalogueNut(1e-3 * BALL, 1e-3 * (SWEPT[0] + 0.22 * BALL), lead, 1.0, has_one_turn_circuits=False)


def fit_power_exponent(values: Sequence[Any], abscissas: Sequence[Any]) -> float:
    """Return the exponent n of the power law ``values`` ~ ``abscissas``^n, by least squares of the logarithms."""
    return float(np.polyfit(np.log(abscissas), np.log(values), 1)[0])


def compare_rexroth_drag_torques() -> Iterator[outside.PublishedValue]:
    """Yield Rexroth's printed ranges of drag torque, each with the computed torque.

    These ranges are not judged, since the printed torques follow a formula.
    """
    source = makers.read_maker_table("rexroth-preload")
    for row in source.rows:
        if not row["torque_low_Nm"]:
            continue
        share = source.parse_number(row["preload_percent_of_C"])
        preload, double = 0.01 * share * source.parse_number(row["C_N"]), row["nut_kind"] == "double nut"
        torque = drag_torque_of_nut(_nut_of_rexroth_row(source, row), preload, double=double)
        low, high = (source.parse_number(row[k]) for k in ("torque_low_Nm", "torque_high_Nm"))
        what = ("torque", SLIDING, f"{row['nut_kind']} {row['size']}, {share:g} % of C", "N m")
        band, left = outside.ComputedBand.from_values((torque,)), "a formula in disguise"
        one = outside.value_of_table_entry(source, row, "line_values", "torque_high_Nm", what, band, left=left)
        yield replace(one, value=0.5 * (low + high), rounding=0.5 * (high - low))


#: Printed data of the two measured screws: lead [m], rating C [N], preload [N]; nominal diameters [mm] of such screws.
MEASURED_LEAD, MEASURED_C, MEASURED_PRELOAD, DIAMETERS = 8e-3, 16_400.0, 1_500.0, (25.0, 32.0, 40.0)


def drag_torque_of_measured_screws() -> outside.ComputedBand:
    """Return the computed drag torque [N m] of two ball screws whose friction torque was measured, with its range.

    The value belongs to a double nut of the middle nominal diameter, at the default coefficient of friction; the range
    covers all diameters, single and double nuts. The number of turns follows from the dynamic rating C, the ball is the
    largest stock size for the lead.
    """
    ball = 1e-3 * max(b for b in STOCK if b <= 0.635e3 * MEASURED_LEAD)
    found = {}
    for outer in DIAMETERS:
        one = CatalogueNut(ball, 1e-3 * outer + 0.22 * ball, MEASURED_LEAD, 1.0, has_one_turn_circuits=False)
        turns = (MEASURED_C / nut_load_ratings(one, CONFORMITY, 0.95)[0]) ** (1.0 / 0.86)
        for double in (False, True):
            found[outer, double] = drag_torque_of_nut(replace(one, turns=turns), MEASURED_PRELOAD, double=double)
    return outside.ComputedBand.from_values((found[DIAMETERS[1], True], *found.values()))


def compare_measured_drag_torques() -> Iterator[outside.PublishedValue]:
    """Yield the measured mean friction torque of two screws, new and worn, with the computed torque.

    Worn: at the end of the test. Measurements between start and end of the test are left out.
    """
    source = makers.read_maker_table("xjtu-torque")
    band = drag_torque_of_measured_screws()
    ends = {name: [r for r in source.rows if r["screw"] == name] for name in dict.fromkeys(r["screw"] for r in source.rows)}
    for name, rows in ends.items():
        for row, state in ((rows[0], "new"), (rows[-1], "worn")):
            what, maker = ("torque", SLIDING, f"{name}, {state}", "N m"), f"{source.header['maker']}, rig"
            yield outside.value_of_table_entry(source, row, "line", "torque_Nm", what, band, maker=maker)
