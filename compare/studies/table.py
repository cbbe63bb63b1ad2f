"""Table of a scene over several values of its keys: stiffness, preload, pressure, life, and the errors to expect.

Keys are read like those of a sweep; ``load`` stands for the axial component of the scene's only axial load. A combination
of values that the scene or the model refuses, or without equilibrium, becomes a row whose status gives the reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.models.answers import TANGENT_OF, tangent_stiffness_at
from rollbench.compare.models.many import solve_many, stored_in
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import estimate_model_error
from rollbench.compare.models.registry import default_model_name
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.table import CONVERGED, QUANTITIES, Over, Table, TableRow
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies import columns
from rollbench.compare.studies.sweep import keys as sweep_keys
from rollbench.compare.studies.sweep import sample
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.meshes import units
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import split_quantity_text

#: Quantities of a table unless others are requested.
USUAL = ("stiffness", "preload", "pressure", "life")

#: Largest number of rows of a table.
MOST = 100_000


@dataclass(frozen=True)
class SceneTableRequest(sample.VariedScene):
    """Checked request for a table of results of a scene over several values of its keys, such as the contact angle."""

    #: Name of the scene.
    name: str
    #: Columns of the table that hold the values of the varied keys, one for each key.
    key_columns: tuple[Over, ...]
    #: Name of the model.
    model: str
    #: Names of the requested quantities, keys of `QUANTITIES`.
    quantities: tuple[str, ...]
    #: Axial position [m] at which the stiffness is requested, or name of a nut or bearing; None: centre of the nut or, for
    #: the scene of a shaft, the position that the scene states.
    stiffness_position: float | str | None
    #: Text that names the body whose displacement defines the stiffness, and what is held fixed.
    stiffness_body_text: str


def check_table_request(
    scene: str, over: Sequence[str], quantities: Sequence[str], model: str = "", stiffness_at: str | float | None = None
) -> SceneTableRequest:
    """Check a request for a table of a scene over values of its keys, before anything is solved.

    Parameters
    ----------
    scene
        Name or file of the scene.
    over
        Keys with their values, such as ``track.contact_angle=40:50:3 deg``.
    quantities
        Names of the quantities of each row, keys of `QUANTITIES`; empty: `USUAL`.
    model
        Name of the model; empty: the default.
    stiffness_at
        Where the stiffness is taken: axial position [m], position as text with its unit, or name of a nut or bearing; None:
        the default.

    Returns
    -------
    SceneTableRequest
        The request.

    Raises
    ------
    InputError
        If scene, key, unit, quantity or model is unknown.
    """
    described = scene_file.scene_or_shaft_or_raise(catalogue.scene_of_any_kind(scene), scene)
    text, origin = catalogue.scene_text_and_file_name(scene)
    for name in quantities:
        if name not in QUANTITIES:
            raise ArgumentError("quantities", name, ", ".join(QUANTITIES), "give names separated by commas")
    model = model or default_model_name(described)
    _check_model_for_table(described, model, quantities)
    typed = sweep_keys.read_varied_keys_of_table(over)
    keys = sweep_keys.with_axial_load_key(typed, scene_file.parse_toml(text, origin), origin, "over")
    sample.VariedScene(text, origin, keys).check_keys()
    if math.prod(len(x.listed_values) for x in keys) > MOST:
        given = f"more than {MOST} combinations of values of the keys"
        raise ArgumentError("over", given, f"up to {MOST} combinations", "give fewer values")
    columns, wanted = tuple(_column_of_varied_key(x) for x in typed), tuple(quantities) or USUAL
    stiffness = _position_and_body_of_stiffness(stiffness_at, described)
    return SceneTableRequest(text, origin, keys, described.name, columns, model, wanted, *stiffness)


def _check_model_for_table(scene: Scene | Assembly, model: str, quantities: Sequence[str]) -> None:
    """Raise InputError if a model is unknown, does not cover the scene, or cannot compute a requested stiffness matrix."""
    sample.check_model(scene, model)
    needs_matrix = isinstance(scene, Scene) and "stiffness" in (quantities or USUAL)
    if needs_matrix and TANGENT_OF.get(model, model) not in LADDER:
        allowed = ", ".join((*LADDER, *TANGENT_OF))
        advice = "leave stiffness out of `quantities`, as the model has no stiffness matrix, or choose another model"
        raise ArgumentError("model", model, allowed, advice)


def _position_and_body_of_stiffness(given: str | float | None, scene: Scene | Assembly) -> tuple[float | str | None, str]:
    """Return the axial position at which the stiffness is requested, then a text on which body moves and which is fixed.

    ``given``: the position as the user wrote it. The returned position is a number [m], the name of a nut or bearing, or
    None for the default. Raises InputError for a position that the shaft does not have.
    """
    names = [x.name for x in scene.sets] if isinstance(scene, Assembly) else []
    if given in names:
        return given, f"nut or bearing {given}, its inner part moved and its outer part fixed"
    of = "shaft with all bearings and supports" if names else "screw's section against the held nut, without its shaft"
    if given is None or given == "":
        return None, of
    try:
        station = float(given) if isinstance(given, int | float) else units.parse_quantity(given, "length")
    except ValueError as error:
        allowed = ", ".join(("a length with its unit", *map(units.toml_text, names)))
        raise ArgumentError("stiffness_at", str(given), allowed, str(error)) from None
    if not 0.0 <= station <= scene.screw.length:
        allowed = f"0 mm to {1e3 * scene.screw.length:g} mm"
        raise ArgumentError("stiffness_at", str(given), allowed, "give an axial position on the shaft")
    return station, of


def _column_of_varied_key(vary: sweep_keys.VariedKey) -> Over:
    """Return the table column with the values of a varied key: numbers if all have the same unit, else texts as written."""
    split = [split_quantity_text(str(x)) if not isinstance(x, bool) else None for x in vary.listed_values]
    spelt = {x[1] for x in split if x is not None}
    if None in split or len(spelt) > 1:
        return Over(vary.key, vary.key, vary.listed_values)
    unit = "".join(spelt).replace(" ", "")
    return Over(vary.key, f"{vary.key}_{unit}" if unit else vary.key, tuple(float(x[0]) for x in split if x is not None))


def solve_table_row(request: SceneTableRequest, values: Sequence[Any]) -> TableRow:
    """Solve a scene with one combination of the varied keys' values, and return the row of the table.

    If scene or model do not allow the values, the status of the row says why.

    ``request``: checked request; ``values``: a value for each key.
    """
    try:
        scene = scene_file.scene_or_shaft_or_raise(request.at(values), request.file_name)
        if isinstance(scene, Assembly) and isinstance(request.stiffness_position, float):
            scene = replace(scene, stiffness_at=request.stiffness_position)
        return _solve_scene_for_row(scene, request)
    except InputError as error:
        return TableRow(f"refused: {error}")


def _solve_scene_for_row(scene: Scene | Assembly, request: SceneTableRequest) -> TableRow:
    """Solve a scene and return a table row with the requested quantities.

    ``request``: checked request.
    """
    names = {name for quantity in request.quantities for name in QUANTITIES[quantity][1]}
    solved, found = columns.row_of_scene(scene, request.model, names)
    result = solved.result
    if not result.converged:
        return TableRow(str(result.status))
    matrix, status, of_points = None, CONVERGED, dict[str, Any]()
    errors: dict[str, Any] = {"error_words": "not for several nuts or bearings; rollbench solve has it for a double nut"}
    tangent: TangentStiffness | None = None
    if isinstance(scene, Scene) and isinstance(result, StaticResult):
        errors = _expected_errors_for_row(scene, result)
        if "stiffness" in request.quantities:
            station = request.stiffness_position if isinstance(request.stiffness_position, float) else scene.nut.position
            tangent = tangent_stiffness_at(scene, station, request.model, ModelOptions())
    elif isinstance(result, AxisResult) and "stiffness" in request.quantities:
        of_set = next((s.stiffness for s in result.sets if s.of.name == request.stiffness_position), result.stiffness)
        none = "this position cannot move, or no contact there carries load"
        known = of_set is not None and np.isfinite(of_set).any()
        matrix = np.full((6, 6), np.nan) if of_set is None else of_set
        tangent = TangentStiffness(station=0.0, matrix=matrix, status=CONVERGED if known else none)
    if tangent is not None and tangent.status != CONVERGED:
        status = f"no stiffness: {tangent.status}"
    elif tangent is not None:
        matrix = tangent.matrix
    if {"stiffness", "displacement"} & set(request.quantities):
        points = solved.stiffness
        if points.load_point.along != "z":  # compared along the axis only
            errors |= {"displacement_error": None, "rigidity_error": None}
        for quantity, field in (("stiffness", "tangent"), ("displacement", "displacement")):
            if quantity in request.quantities:
                of_points |= {f"{at}_{field}": getattr(getattr(points, at), field) for at in ("nut", "load_point")}
    pressure = max(columns.largest_pressures(solved), default=None) if "pressure" in request.quantities else None
    kept = ("largest_load_N", "preload_N", "life_million_revolutions")
    load, preload, life = (found.get(name) if name in names else None for name in kept)
    return TableRow(status, matrix, load=load, preload=preload, pressure=pressure, life=life, **of_points, **errors)


def _expected_errors_for_row(scene: Scene, result: StaticResult) -> dict[str, Any]:
    """Return the expected errors of a static result [%], each by the name of its field in `TableRow`.

    The errors are estimated from the model's errors on scenes that were compared with the 3D reference.
    """
    form = estimate_model_error(scene, result)
    errors = {f"{of}_error": getattr(form, of) for of in ("displacement", "rigidity", "pressure")}
    words = "" if form.loads is not None else form.words[-1]
    return {"load_error": form.loads, "rms_error": form.loads_rms, **errors, "error_words": words}


def solve_table(
    request: SceneTableRequest,
    engine: ComputingSettings,
    show_progress: Callable[[str], None],
    store: str | Path | None = None,
) -> Table:
    """Solve all rows of a table.

    Parameters
    ----------
    request
        Checked request.
    engine
        Number of processes, or cluster, that solve the rows.
    show_progress
        Function that is called with each line of progress.
    store
        Folder in which solved rows are looked up and stored; None: none.

    Returns
    -------
    Table
        The table, rows in the order of the keys' values.

    Raises
    ------
    InputError
        If workers of a cluster are lost, or if the folder belongs to another computation.
    """
    request.say_which_keys_are_replaced(show_progress)
    places = list(product(*(vary.listed_values for vary in request.keys)))
    rows: dict[int, TableRow] = {}
    tasks = {number: (request, place) for number, place in enumerate(places)}
    inputs = replace(request, origin=request.file_name, model="")  # wherever the file lies
    stored = stored_in(store, "table", request.model, inputs)
    for number, row in solve_many(solve_table_row, tasks, engine, show_progress, noun="places", stored=stored):
        rows[number] = row
        show_progress(f"[{len(rows)}/{len(places)}] {', '.join(map(str, places[number])) or 'as it stands'}: {row.status}")
    station = request.stiffness_position
    return Table(
        scene=request.name,
        model=request.model,
        over=request.key_columns,
        quantities=request.quantities,
        stiffness_of=request.stiffness_body_text,
        station=station if isinstance(station, float) else None,
        rows=tuple(rows[k] for k in range(len(places))),
    )
