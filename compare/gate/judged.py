"""Quantities other than contact loads that `rollbench check` judges: error limits, values, uncertainties, CSV files.

Contact angle, approach and pressure are judged on every contact; displacement, rigidity, torque and life of the whole
screw. By Hertz the approach of a contact is proportional to F^(2/3) and its largest pressure to F^(1/3); life is
proportional to F^-3. The default limit of these quantities is therefore the limit of the loads times 2/3, 1/3 and 3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.models.answers import motion_of_unloaded_screw, results_of_contact_loads
from rollbench.compare.models.comparison import ContactSolution, mesh_uncertainties, solution_from_run
from rollbench.compare.models.loading import solve_with_scaled_loads
from rollbench.compare.models.loads_file import CsvTable
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import axial_contact_force
from rollbench.compare.models.registry import DEFAULT, run_model
from rollbench.compare.models.stiffness import place_of_displacement, place_text
from rollbench.compare.quantities import name_and_unit_of_key, words_and_unit_of_key
from rollbench.compare.reference.convergence import grid_convergence
from rollbench.compare.reference.estimate import Reference
from rollbench.lowfi.statics.contacts import hertz_of_every_contact
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import UnitError, dimension_description, number_advice, number_of_text, parse_quantity

#: Options with which the default model computes the unloaded position of the screw and the contacts for the friction.
WITHOUT_MESH_ERROR = ModelOptions(estimate_beam_mesh_error=False)
#: Note on quantities whose reference value is computed from contact loads.
BY_FORMULA = "reference value computed by rollbench's formula from the reference's loads"


@dataclass(frozen=True)
class JudgedQuantity:
    """Quantity other than a contact load that `rollbench check` judges, such as the life, with its default error limit."""

    #: Key of the quantity in JSON, which ends with the unit.
    key: str
    #: Name of the quantity in tables, files and options.
    name: str
    #: Ratio of the default error limit of this quantity to the error limit of the contact loads.
    default_limit_ratio: float = 1.0
    #: Default error limit in the unit of the quantity; None: the default is ``default_limit_ratio`` times the error limit
    #: of the contact loads, in per cent.
    default_limit: float | None = None

    @property
    def unit(self) -> str:
        """Unit in which values of the quantity are shown."""
        return words_and_unit_of_key(self.key)[1]

    @property
    def display_factor(self) -> float:
        """Factor that converts a value of the quantity from SI units to the unit in which it is shown; 1 for a life."""
        unit = name_and_unit_of_key(self.key)[1]
        return 1.0 if unit is None else unit.factor


#: Quantities that `rollbench check` judges on every contact.
ANGLE = JudgedQuantity("contact_angle_deg", "contact angle", default_limit=1.0)
APPROACH = JudgedQuantity("approach_um", "approach", 2.0 / 3.0)
PRESSURE = JudgedQuantity("pressure_MPa", "pressure", 1.0 / 3.0)
#: Quantities of the whole screw that `rollbench check` judges. Displacement and rigidity (secant) are those of the point on
#: which the load acts, along z and to ground, as the 3D reference gives them.
DISPLACEMENT = JudgedQuantity("load_point_displacement_um", "displacement")
RIGIDITY = JudgedQuantity("load_point_secant_N_per_um", "rigidity")
TORQUE = JudgedQuantity("torque_Nmm", "torque")
LIFE = JudgedQuantity("life_million_revolutions", "life", 3.0)
#: Judged quantities of every contact, by their columns in a CSV file; judged quantities of the whole screw; all by name.
OF_CONTACTS = {"angle": ANGLE, "approach": APPROACH, "pressure": PRESSURE}
OF_WHOLE = (DISPLACEMENT, RIGIDITY, TORQUE, LIFE)
QUANTITIES = {q.name: q for q in (*OF_CONTACTS.values(), *OF_WHOLE)}


def parse_error_limits(texts: Sequence[str]) -> dict[str, float]:
    """Parse the user's error limits for quantities other than contact loads.

    Parameters
    ----------
    texts
        Limits as ``NAME=NUMBER``, in per cent, or in degrees for the contact angle.

    Returns
    -------
    dict
        Limit of the error by name of the quantity.

    Raises
    ------
    InputError
        If a quantity is unknown or stated twice, or a number is not valid.
    """
    out: dict[str, float] = {}
    for text in texts:
        name, _, number = text.partition("=")
        name = name.strip().lower().replace("_", " ")
        name = ANGLE.name if name == "angle" else name
        allowed = f"NAME=NUMBER with a number above 0, each NAME once, out of the names {', '.join(QUANTITIES)}"
        advice = "state the limit in per cent, of the contact angle in degrees, such as rigidity=10; loads: `max_error`"
        value = number_of_text(number)
        if name not in QUANTITIES or name in out or not 0.0 < value < float("inf"):
            raise ArgumentError("limits", f'"{text}"', allowed, number_advice(number, advice))
        out[name] = value
    return out


def hertz_approach_or_pressure(scene: Scene, quantity: JudgedQuantity, load: Array) -> Array:
    """Compute the elastic approach [m] or the largest pressure [Pa] of all contacts from their loads by Hertz's theory.

    ``quantity``: `PRESSURE` for the pressure, any other for the approach; ``load``: contact loads of n balls on 4
    flanks (n, 4) [N]. The result has the shape of the loads.
    """
    h = hertz_of_every_contact(scene, draw_geometry_with_errors(scene, ball_layout(scene)))
    return h.pressure(load) if quantity is PRESSURE else np.asarray(h.C * np.cbrt(load) ** 2)


def uncertainty_from_loads(
    quantity_of_loads: Callable[[Array], Array | float | None], load: Array, uncertainty: Array
) -> Array | float | None:
    """Return the uncertainty of a quantity due to the uncertainty of the contact loads from which it is computed.

    All loads are raised together, then lowered together, by their uncertainty.

    Parameters
    ----------
    quantity_of_loads
        Function that computes the quantity from the loads; monotone in each load.
    load
        Contact loads of n balls on 4 flanks, (n, 4) [N].
    uncertainty
        Uncertainty of the loads, (n, 4) [N].

    Returns
    -------
    Array | float | None
        Larger of the two changes of the quantity; None if the quantity has no value.
    """
    bars = np.where(load > 0.0, uncertainty, 0.0)
    value, *ends = (quantity_of_loads(x) for x in (load, load + bars, np.maximum(load - bars, 0.0)))
    if value is None or any(end is None for end in ends):
        return None
    return np.max([np.abs(end - value) for end in ends], axis=0)  # type: ignore[operator, no-any-return]


def contact_quantity_of_reference(scene: Scene, reference: Reference, quantity: JudgedQuantity) -> tuple[Array, Array]:
    """Return the reference's values of a contact quantity (angle, approach or pressure), and their uncertainty.

    Both are arrays (n, 4) in SI units, for n balls on 4 flanks; an uncertainty that is not known is nan.
    """
    given = reference.further.get(quantity.name)
    if quantity is ANGLE:
        bars = np.zeros_like(reference.load) if reference.stated else mesh_uncertainties(reference, lambda run: run.angle)
        return np.radians(reference.best.angle), np.radians(bars)
    load, value_of = reference.load, hertz_approach_or_pressure
    bar = uncertainty_from_loads(lambda x: value_of(scene, quantity, x), load, reference.uncertainty)
    return value_of(scene, quantity, load) if given is None else given, np.asarray(bar)


@dataclass(frozen=True)
class WholeScrewEvaluation:
    """Evaluation of a scene's contact loads: displacement, rigidity, torque and life of the whole screw."""

    #: Scene whose screw is evaluated.
    scene: Scene

    @cached_property
    def unloaded_position(self) -> float:
        """Axial displacement of the load's point without external loads by the default model [m].

        It is also used for the 3D reference, of which no run without loads exists.
        """
        bare = solve_with_scaled_loads(self.scene, 0.0, DEFAULT, WITHOUT_MESH_ERROR)
        return float(motion_of_unloaded_screw(bare, place_of_displacement(self.scene))[2])

    def value_of(self, quantity: JudgedQuantity, answer: ContactSolution, station: float | None = None) -> float | None:
        """Return a quantity of the whole screw in SI units (a life in million revolutions), by a model or a 3D run.

        ``answer``: contact loads and displacements by the model or run; ``station``: axial position at which a displacement
        is taken [m]; None: where the load acts. None is returned if the quantity is not defined for these loads.
        """
        angle = np.radians(answer.angle)
        if quantity is LIFE:
            life = results_of_contact_loads(self.scene, answer.load, angle).life_by_loads
            return None if life is None else life.revolutions
        if quantity is TORQUE:
            return self._friction_torque(answer.load, angle)
        at = place_of_displacement(self.scene) if station is None else station
        if not answer.stations.size:
            return None
        moved = float(np.interp(at, answer.stations, answer.line[:, 2])) - self.unloaded_position
        if quantity is DISPLACEMENT:
            return moved
        force = axial_contact_force(self.scene, answer.load, angle)
        return force / moved if moved * force > 0.0 else None

    def reference_value_and_uncertainty(
        self, quantity: JudgedQuantity, ref: Reference, station: float | None = None
    ) -> tuple[float | None, float | None]:
        """Return the reference's value of a quantity of the whole screw, and its uncertainty, in SI units; None if unknown.

        ``ref``: the reference; ``station``: axial position of a displacement [m], None: where the load acts. A life is in
        million revolutions.
        """
        answers = [solution_from_run(run, "") for run in ref.runs]
        if quantity in (TORQUE, LIFE):
            run = answers[-1]
            bar = uncertainty_from_loads(lambda x: self.value_of(quantity, replace(run, load=x)), ref.load, ref.uncertainty)
            return self.value_of(quantity, run), None if bar is None else float(bar)
        values = [value for answer in answers if (value := self.value_of(quantity, answer, station)) is not None]
        if len(values) < len(answers):
            return None, None
        return values[-1], grid_convergence(values, ref.sizes).uncertainty

    def reason_without_value(self, quantity: JudgedQuantity, ref: Reference) -> str:
        """Return the reason why the reference ``ref`` gives no value of a quantity of the whole screw."""
        if quantity is TORQUE:
            return "the scene has no [friction]" if self.scene.friction is None else "the friction model finds no torque"
        if quantity is LIFE:
            found = results_of_contact_loads(self.scene, ref.load, np.radians(ref.best.angle))
            return found.rating_refused or "no contact carries load"
        if ref.stated:
            return f"{ref.label} states no value of it"
        return "the screw does not move in the direction of its load"

    def computation_note(self, quantity: JudgedQuantity, station: float | None) -> str:
        """Return a note on how the reference's value of a quantity of the whole screw is computed.

        ``station``: axial position of a displacement [m], None: where the load acts.
        """
        if quantity in (TORQUE, LIFE):
            return BY_FORMULA
        at = f"to ground at {place_text(place_of_displacement(self.scene) if station is None else station)}"
        if not self.unloaded_position:
            return at
        start = f"{1e6 * self.unloaded_position:.3g} um by the model {DEFAULT}"
        return f"{at}, measured from the position without loads, {start}"

    def _friction_torque(self, load: Array, angle: Array) -> float | None:
        """Compute the friction torque [N m] of the screw from contact loads and angles; None if it cannot be computed.

        It cannot be computed without coefficients of friction, or if the default model finds no equilibrium.

        ``load``: contact loads of n balls on 4 flanks (n, 4) [N]; ``angle``: contact angles (n, 4) [rad]. Angles that
        are nan are replaced by those of the default model.
        """
        solved = self._default_solution
        if self.scene.friction is None or not solved.converged:
            return None
        result = replace(solved, load=load, contact_angle=np.where(np.isfinite(angle), angle, solved.contact_angle))
        from rollbench.compare.models.friction_sums import UnsolvedTorque, total_friction_torques

        torque = UnsolvedTorque([(self.scene, result)], self.scene.friction, self.scene.motion, WITHOUT_MESH_ERROR.member)
        (value,) = total_friction_torques([torque])
        return None if value is None else 1e-3 * value

    @cached_property
    def _default_solution(self) -> StaticResult:
        """Solution of the scene by the default model; to compute friction, its loads and angles are replaced by others."""
        return run_model(self.scene, DEFAULT, WITHOUT_MESH_ERROR)


#: Required columns of a user's file with values of the whole screw.
VALUE_COLUMNS = ("quantity", "value", "unit")

#: Column for the axial load or the axial position at which a value applies.
WHERE = "where"

#: Advice in error messages with an example of a user's file of values.
VALUE_EXAMPLE = "begin with the line quantity,value,unit,where and add rows such as rigidity,540,N/um,5 kN"

#: Dimension of the unit of each quantity of the whole screw except life.
DIMENSIONS = {DISPLACEMENT: "length", RIGIDITY: "stiffness", TORQUE: "moment"}

#: Accepted units of life, each with its size in million revolutions.
LIVES = {"million revolutions": 1.0, "1e6 revolutions": 1.0, "revolutions": 1e-6}


@dataclass(frozen=True)
class UserValue:
    """A user's value of a quantity of the whole screw (such as rigidity or life), which is to be judged."""

    #: Quantity that the value belongs to.
    quantity: JudgedQuantity
    #: Value in SI units; a life in million revolutions.
    value: float
    #: Axial load at which the value applies [N]; None: the loads of the scene.
    axial_load: float | None = None
    #: Axial position at which a displacement applies [m]; None: where the load acts.
    station: float | None = None
    #: Text in the file's column ``where``: load or axial position of the value; may be empty.
    load_or_position_text: str = ""
    #: Number or name of the nut or bearing on the shaft, as written in the file; empty: none is written.
    set: str = ""

    @property
    def name(self) -> str:
        """Name of the quantity, with the load or position at which the value applies."""
        return self.quantity.name + (f" at {self.load_or_position_text}" if self.load_or_position_text else "")


def read_user_values(path: Path, case: str | None = None) -> tuple[list[UserValue], tuple[str, ...]]:
    """Read a user's values of the whole screw (such as rigidity or life), which are to be judged, from a CSV file.

    Parameters
    ----------
    path
        Path of the file, with the columns quantity, value and unit, and optionally where (axial load or position at which
        the value applies), set (nut or bearing) and case (load case).
    case
        Load case whose rows are read, as named in the column ``case``; None: all rows.

    Returns
    -------
    list[UserValue]
        Values in the order of the rows.
    tuple[str, ...]
        Column headings of the file that are not known.

    Raises
    ------
    InputError
        If the file cannot be read, a value or unit is not valid, or a value is stated twice.
    """
    needed = (*VALUE_COLUMNS, *(("case",) if case else ()))
    optional = (WHERE, "set")
    table = CsvTable.from_csv(path, needed, VALUE_EXAMPLE, optional)
    out: dict[tuple[str, ...], UserValue] = {}
    for number, cells in table.numbered_rows:
        if case is not None and cells.get("case") != case:
            continue
        given = _user_value_in_row(path, f"line {number}", cells, decimal_comma=table.decimal_comma)
        key = (given.name, given.set)
        if key in out:
            allowed = "one row for each quantity and load or position"
            raise InputError(str(path), f"line {number}", f"{given.name} again", allowed, "delete one of the rows")
        out[key] = given
    if not out and case is None:
        raise InputError(str(path), "file", "no values", "a row for each value", VALUE_EXAMPLE)
    return list(out.values()), tuple(f'"{title}"' for title in table.headings if title.lower() not in (*needed, *optional))


def _user_value_in_row(path: Path, line: str, cells: dict[str, str], *, decimal_comma: bool) -> UserValue:
    """Return the value of the whole screw that one row of a user's file states; InputError if a cell is not valid.

    ``line``: number of the line, as text; ``cells``: texts of the row by column; ``decimal_comma``: whether a comma is the
    decimal mark of numbers.
    """
    name, number, unit = (cells.get(column, "") for column in VALUE_COLUMNS)
    quantity = next((q for q in OF_WHOLE if q.name == name.lower()), None)
    if quantity is None:
        allowed = ", ".join(q.name for q in OF_WHOLE)
        advice = "choose one of these quantities; put values of single contacts into the file of `loads`"
        raise InputError(str(path), f"{line}: quantity", name or "nothing", allowed, advice)
    text = f"{number.replace(',', '.') if decimal_comma else number} {unit}"
    try:
        if quantity is LIFE:
            value = number_of_text(text.split(" ")[0]) * LIVES.get(unit.lower(), float("nan"))
            if not 0.0 < value < float("inf"):
                raise ValueError(unit)
        else:
            value = parse_quantity(text, DIMENSIONS[quantity])
    except ValueError as error:
        allowed, advice = f"a number and one of: {', '.join(LIVES)}", number_advice(text, VALUE_EXAMPLE)
        if isinstance(error, UnitError):
            allowed = dimension_description(DIMENSIONS[quantity])
            advice = number_advice(f"{number},{unit}", error.advice)
        raise InputError(str(path), f"{line}: value, unit", text.strip() or "nothing", allowed, advice) from None
    where = cells.get(WHERE, "")
    plain = where.replace(",", ".") if decimal_comma else where
    force, station = (_load_or_length_in_si(plain, of) for of in ("force", "length"))
    if where and force is None and (station is None or quantity is not DISPLACEMENT):
        position = ", or an axial position such as 400 mm" if quantity is DISPLACEMENT else ""
        allowed = f"an axial load such as 5 kN{position}"
        advice = number_advice(where, "leave the cell empty for the loads of the scene")
        raise InputError(str(path), f"{line}: {WHERE}", where, allowed, advice)
    return UserValue(quantity, value, force, station, where, cells.get("set", ""))


def _load_or_length_in_si(text: str, dimension: str) -> float | None:
    """Parse a load or position such as ``5 kN`` and return it in SI units; None if its unit is not of the dimension.

    ``dimension``: "force" or "length". None is also returned for a force that is not positive.
    """
    try:
        value = parse_quantity(text, dimension)
    except UnitError:
        return None
    return value if value > 0.0 or dimension == "length" else None
