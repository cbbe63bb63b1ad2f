"""A solved scene, of one set or several, as one JSON object."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.models.registry import random_errors
from rollbench.compare.quantities import number, quantity, record
from rollbench.compare.results.answers_json import (
    answers_json,
    set_json,
    sides_json,
    stiffness_json,
    whole_json,
    whole_stiffness,
)
from rollbench.lowfi.rating.roller_contacts import RACES, race_pressures
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Scene

#: Units of the six motions in results, and factors to them.
MOTION = (("ux_um", 1e6), ("uy_um", 1e6), ("uz_um", 1e6), ("rx_mrad", 1e3), ("ry_mrad", 1e3), ("rz_mrad", 1e3))
#: Forces and moments on the shaft, and what they leave.
EQUILIBRIUM = (
    quantity("external_force_N", "applied_force"),
    quantity("external_moment_Nm", "applied_moment"),
    quantity("reaction_force_N"),
    quantity("reaction_moment_Nm"),
    quantity("contact_force_N"),
    quantity("contact_moment_Nm"),
    quantity("force_residual"),
    quantity("moment_residual"),
    quantity("pin_force_N"),
    quantity("pin_moment_Nm"),
    quantity("pin_share"),
    quantity("ball_residual"),
)
#: How the solution came about; the error of the beam is told by who measured it.
SOLVER = (
    quantity("iterations"),
    quantity("residual"),
    quantity("seconds"),
    quantity("unknowns"),
    quantity("elements"),
    quantity("evaluations"),
    quantity("engine"),
    quantity("formulation"),
    quantity("round_off_bound"),
    quantity("discretisation_percent", lambda _: None),
    quantity("notes"),
)
#: The error to expect.
MODEL_FORM = (
    quantity("covered", lambda m: m.percent is not None),
    quantity("largest_percent_of_mean", "percent"),
    quantity("rms_percent_of_mean", "rms_percent"),
    quantity("displacement_percent", "displacement_percent"),
    quantity("rigidity_percent", "rigidity_percent"),
    quantity("pressure_percent", "pressure_percent"),
    quantity("distance"),
    quantity("nearest"),
    quantity("compared"),
    quantity("words"),
)
#: One set of several.
SET = (
    quantity("name", "of.name"),
    quantity("kind", "of.kind"),
    quantity("position_mm", "of.position"),
    quantity("housing", "of.housing"),
    quantity("offset_um", "of.offset"),
    quantity("force_on_shaft_N", "force"),
    quantity("moment_on_shaft_Nm", "moment"),
    quantity("largest_load_N", lambda s: s.loads.max(initial=0.0)),
    quantity("loaded", lambda s: int((s.loads > 0.0).sum()) if np.isfinite(s.loads).all() else None),
    quantity("outer_motion", lambda s: motion_json(s.outer)),
    quantity("stiffness"),
)
#: A housing of several sets.
HOUSING = (
    quantity("name"),
    quantity("motion", lambda h: motion_json(h.motion)),
    quantity("frame_force_N", lambda h: h.wrench[:3]),
    quantity("frame_moment_Nm", lambda h: h.wrench[3:]),
    quantity("residual"),
)


def motion_json(motion: Array) -> dict[str, float]:
    """A motion ``(6,)`` [m, rad] in um and mrad by its freedoms."""
    return {name: factor * x for (name, factor), x in zip(MOTION, motion, strict=True)}


def case_json(one: Solved | SolvedAxis, tangent: Tangent | None = None) -> dict[str, Any]:
    """A solved scene as a JSON-ready object: angles in deg, stations in mm, displacements in um, forces in N. Of several
    sets rows of balls and rollers begin with their set, sums of a set are in ``sets``. tangent: the stiffness at a station,
    where it was asked for of one set."""
    scene, result = one.scene, one.result
    head: dict[str, Any] = {"scene": scene.name}
    if isinstance(one, SolvedAxis):
        of_sets = [None] * len(one.result.sets) if one.answers is None else one.answers.sets
        head["kind"] = one.scene.kind
        pairs = enumerate(zip(one.result.sets, of_sets, strict=True), 1)
        sets = [{"set": k, **(record(SET, s) or {}), "summary": set_json(s, x, scene.motion)} for k, (s, x) in pairs]
        answers = {
            "sets": sets,
            "balls": set_balls(one.result),
            "rollers": rollers(one.result),
            "summary": whole_json(one),
            "housings": [record(HOUSING, h) for h in one.result.housings],
            "stiffness": whole_stiffness(one.result),
        }
    else:
        summary = {"sides": sides_json(one.result.load), **answers_json(one)}
        if tangent is not None and one.answers is not None:
            summary["stiffness"] = stiffness_json(tangent.station, tangent.status, tangent.matrix)
        answers = {"balls": ball_rows(one.result), "summary": summary if np.isfinite(one.result.load).all() else {}}
    grid = discretisation_percent(one.scene, one.result) if isinstance(one, Solved) else None
    return {
        **head,
        "model": result.model,
        "member": result.member if random_errors(scene) else None,
        "status": result.status,
        **answers,
        "centreline": [
            {"z_mm": number(1e3 * z), "ux_um": number(1e6 * u[0]), "uy_um": number(1e6 * u[1]), "uz_um": number(1e6 * u[2])}
            for z, u in zip(result.centreline_z, result.centreline, strict=True)
        ],
        "equilibrium": record(EQUILIBRIUM, result.equilibrium),
        "solver": (record(SOLVER, result.solver) or {}) | {"discretisation_percent": grid},
        "model_form": record(MODEL_FORM, one.expected),
        "assumed": list(result.assumed),
        "left_out": list(result.left_out),
        "warning": above(result.warnings) or None,
        "warnings": list(result.warnings),
    }


def expected_json(m: ModelForm | None, key: str) -> dict[str, float | None]:
    """Expected errors [%] beside those of loads, by ``key`` with the quantity's name; null where not covered."""
    errors = {
        name: None if m is None else getattr(m, f"{name}_percent") for name in ("displacement", "rigidity", "pressure")
    }
    return {key.format(name): None if value is None else number(value) for name, value in errors.items()}


def discretisation_percent(scene: Scene, result: StaticResult) -> float | None:
    """Discretisation error of the beam in per cent of the mean contact load, where it was measured."""
    change = result.solver.discretisation
    if change is None:
        return None
    return number(float(error_percent(change, 0.0, mean_load(result.load, nominal_contacts(scene, result)))))


def per_side(row: Array) -> dict[str, float | None]:
    """Values (4,) by the names of the flanks."""
    return {side: number(value) for side, value in zip(SIDES, row, strict=True)}


def ball_rows(balls: StaticResult) -> list[dict[str, Any]]:
    """Place, loads and contact angles of every ball, numbered from 1."""
    return [
        {
            "index": i + 1,
            "azimuth_deg": number(math.degrees(balls.azimuth[i])),
            "z_mm": number(1e3 * balls.z[i]),
            "load_N": per_side(balls.load[i]),
            "contact_angle_deg": per_side(np.degrees(balls.contact_angle[i])),
        }
        for i in range(balls.z.size)
    ]


def set_balls(result: AxisResult) -> list[dict[str, Any]]:
    """One row per ball, numbered from 1 in each set."""
    of_balls = ((k, s.balls) for k, s in enumerate(result.sets, 1) if s.balls is not None)
    return [{"set": k} | row for k, balls in of_balls for row in ball_rows(balls)]


def rollers(result: AxisResult) -> list[dict[str, Any]]:
    """One row per roller, numbered from 1 in each set."""
    rows = []
    for k, s in enumerate(result.sets, 1):
        if not isinstance(s.of.parts, RollerRow) or s.roller_azimuth is None or s.line_loads is None:
            continue
        pressures = race_pressures(s.of.parts, s.line_loads)
        for i, (azimuth, load) in enumerate(zip(s.roller_azimuth, s.loads, strict=True)):
            of_races = {race: number(1e-6 * p) for race, p in zip(RACES, pressures[i], strict=True)}
            rows.append(
                {
                    "set": k,
                    "index": i + 1,
                    "azimuth_deg": number(math.degrees(azimuth)),
                    "load_N": number(load),
                    "largest_line_load_N_mm": number(1e-3 * s.line_loads[i].max()),
                    "pressure_MPa": of_races,
                }
            )
    return rows
