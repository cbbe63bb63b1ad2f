"""A solved scene, of one set or several, as one JSON object, and for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.commands.printing import Column, text_width
from rollbench.compare.commands.solving.entries import block, load_error
from rollbench.compare.commands.solving.summary import (
    answers_json,
    set_json,
    sides_json,
    stiffness_json,
    whole_json,
    whole_stiffness,
)
from rollbench.compare.commands.tables import listed, of_quantities, plain
from rollbench.compare.measure import error_percent
from rollbench.compare.models.load_cases import Solved, SolvedAxis
from rollbench.compare.models.model_form import ModelForm
from rollbench.compare.models.registry import random_errors
from rollbench.compare.quantities import count_of, number, quantity, record, shown
from rollbench.lowfi.rating.roller_contacts import RACES, race_pressures
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, Equilibrium, SolverReport, StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.lowfi.warned import above
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene

if TYPE_CHECKING:
    from rich.console import RenderableType


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
    quantity("outer_motion", lambda s: _motion(s.outer)),
    quantity("stiffness"),
)
#: What the table of sets says of each.
SETS = (
    quantity("name", "of.name", form="s"),
    quantity("kind", "of.kind", form="s"),
    quantity("position_mm", "of.position", "z", ".2f"),
    quantity("force_x_N", lambda s: s.force[0], "Fx", ".2f"),
    quantity("force_y_N", lambda s: s.force[1], "Fy", ".2f"),
    quantity("force_z_N", lambda s: s.force[2], "Fz", ".2f"),
    quantity("largest_N", lambda s: s.loads.max(initial=0.0), "largest load", ".2f"),
    quantity("loaded", lambda s: int((s.loads > 0.0).sum()), form="s"),
    quantity("axial_N_per_um", lambda s: s.stiffness[2, 2], form=".2f"),
    quantity("x_N_per_um", lambda s: s.stiffness[0, 0], "along x", ".2f"),
    quantity("y_N_per_um", lambda s: s.stiffness[1, 1], "along y", ".2f"),
)
#: A housing of several sets.
HOUSING = (
    quantity("name"),
    quantity("motion", lambda h: _motion(h.motion)),
    quantity("frame_force_N", lambda h: h.wrench[:3]),
    quantity("frame_moment_Nm", lambda h: h.wrench[3:]),
    quantity("residual"),
)


def _motion(motion: Array) -> dict[str, float]:
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


def case_table(one: Solved | SolvedAxis, *, balls: bool = False, details: bool = False) -> list[Any]:
    """A solved scene for the terminal: warnings and the block of answers, tables; then balance and solver, assumptions and
    what was left out, or where they are. balls: with the table of every ball; details: with what lies behind the answers
    (always where there are none)."""
    answers, result = block(one, text_width()), one.result
    above_all, measured = above(result.warnings), ""
    behind = [] if result.equilibrium is None else _balance(result.equilibrium, several=isinstance(one, SolvedAxis))
    if isinstance(one, SolvedAxis):
        sets = count_of(len(one.scene.sets), "set")
        titles = [f"{one.scene.name}, {sets}, model {result.model}: {result.status}", one.scene.title]
        tables = _set_tables(one.result, balls=balls)
    else:
        drawn = f", member {result.member} of its random errors" if random_errors(one.scene) else ""
        titles = [f"{one.scene.name}{drawn}, model {result.model}: {result.status}"]
        tables = _ball_tables(one) if balls and (one.result.load > 0.0).any() else []
        grid = discretisation_percent(one.scene, one.result)
        measured = "" if grid is None else f" (discretisation error {grid:.1e} % of the mean load)"
    behind += solver_lines(result.solver, measured)
    notes = [f"note: {line}" for line in result.solver.notes]
    return [
        *titles,
        *(["", above_all] if above_all else []),
        *(["", answers, ""] if answers else []),
        *tables,
        *closing_lines(
            result.warnings, behind, result.assumed, result.left_out, details=details or not answers, notes=notes
        ),
    ]


def closing_lines(
    warnings: Sequence[str],
    behind: Sequence[str],
    assumed: Sequence[str],
    left_out: Sequence[str],
    *,
    details: bool,
    notes: Sequence[str] = (),
) -> list[str]:
    """Warnings, then what lies behind the answers: lines on balance and solver, notes, assumptions, what was left out; or
    where to find it."""
    warned = [f"warning: {line}" for line in warnings]
    if not details:
        counted = f"{count_of(len(assumed), 'assumption')}, {count_of(len(left_out), 'thing')} left out"
        return [*warned, f"{counted}, balance and solver: --assumptions"]
    headed = ("assumed", assumed), ("left out", left_out)
    return [*behind, *warned, *notes, *(f"{heading}: {line}" for heading, lines in headed for line in lines)]


def solver_lines(s: SolverReport, measured: str = "") -> list[str]:
    """How the solution came about; only the time where nothing was solved. measured: of the elements."""
    if not math.isfinite(s.residual):
        return [f"refused before anything was solved for, in {s.seconds:.3g} s"]
    return [
        f"solver: {s.formulation}, {s.engine}; {count_of(s.iterations, 'iteration')}, residual {s.residual:.1e}, "
        f"{count_of(s.unknowns, 'unknown')}, {count_of(s.elements, 'beam element')}{measured}, {s.seconds:.3g} s"
    ]


def _balance(e: Equilibrium, *, several: bool) -> list[str]:
    sums = f"force {e.force_residual:.1e}, moment {e.moment_residual:.1e}"
    if several:
        return [f"balance of the shaft: {sums} (relative)"]
    of_parts = f"(relative, sums over loads, reactions and contact points); of the balls: {e.ball_residual:.1e}"
    lines = [f"balance of the screw: {sums} {of_parts}"]
    if e.pin_share > 0.0:
        lines.append(
            f"no support of the scene holds a free motion: its pin takes {100.0 * e.pin_share:.2g} % of the largest "
            "force or moment, by which the balance of what the supports can carry is open"
        )
    return lines


def _ball_tables(one: Solved) -> list[RenderableType]:
    """Every ball, and the sums of each flank; loads to the digits that their expected error leaves."""
    result = one.result
    error = load_error(mean_load(result.load, nominal_contacts(one.scene, result)), one.expected)
    sides = [k for k in range(4) if (result.load[:, k] > 0.0).any()]
    headings, rows = ["ball", "deg", "z mm", *(x for k in sides for x in (f"{SIDES[k]} N", "angle"))], []
    for i in range(result.z.size):
        cells = [str(i + 1), f"{math.degrees(result.azimuth[i]):.1f}", f"{1e3 * result.z[i]:.2f}"]
        for k in sides:
            angle = math.degrees(result.contact_angle[i, k])
            cells += [shown(result.load[i, k], error), f"{angle:.2f}" if math.isfinite(angle) else "–"]
        rows.append(cells)
    sums = (
        (side, *(shown(row[k], error) for k in ("max_N", "min_N", "ratio")), str(row["loaded"]), str(row["lost"]))
        for side, row in sides_json(result.load).items()
    )
    summed = plain(("side", "max N", "min N", "max/min", "loaded", "lost"), sums)
    return [plain(headings, rows), "", summed, ""]


def stiffness_lines(tangent: Tangent) -> list[RenderableType]:
    """The stiffness at a section as a table to read, N/um and kN m/rad in their places."""
    if tangent.status != "converged":
        return [f"stiffness at {1e3 * tangent.station:.6g} mm: {tangent.status}"]
    rows = ((name, *(f"{x:.4g}" for x in row)) for name, row in zip(FREEDOMS, tangent.matrix, strict=True))
    head = (
        f"tangent stiffness of the screw's section at {1e3 * tangent.station:.6g} mm against the held nut, without the "
        "screw's supports; forces and moments over displacements and rotations, N, m, rad"
    )
    return ["", head, plain(("", *FREEDOMS), rows)]


def _set_tables(result: AxisResult, *, balls: bool) -> list[RenderableType]:
    """Sets, balls and rollers where asked for, housings, stiffness."""
    out: list[RenderableType] = []
    if result.sets and result.converged:
        out += [of_quantities("sets: force on the shaft, stiffness of the set alone", SETS, result.sets)]
        out += _element_tables(result) if balls else []
    for h in result.housings if result.converged else ():
        moved = ", ".join(f"{n.split('_')[0]} {x:.4g} {n.split('_')[1]}" for n, x in _motion(h.motion).items())
        force = ", ".join(f"{x:.5g}" for x in h.wrench[:3])
        out.append(f"{h.name}: {moved}; the frame holds it with ({force}) N; balance {h.residual:.1e}")
    return [*out, *_stiffness_lines(result)]


def _element_tables(result: AxisResult) -> list[RenderableType]:
    """Balls by set and index, with the sides that carry load; rollers."""
    out: list[RenderableType] = []
    rows = set_balls(result)
    loaded = [s for s in SIDES if any((r["load_N"][s] or 0.0) > 0.0 for r in rows)]
    if loaded:
        columns: list[Column] = [("set", "set", "s"), ("index", "ball", "s"), ("azimuth_deg", "azimuth deg", ".2f")]
        for side in loaded:
            columns += [(f"{side} N", f"{side} N", ".3f"), (f"{side} deg", "angle deg", ".3f")]
        flat = [
            r | {f"{s} N": r["load_N"][s] for s in loaded} | {f"{s} deg": r["contact_angle_deg"][s] for s in loaded}
            for r in rows
        ]
        out.append(listed("balls", columns, flat))
    found = rollers(result)
    if found:
        names = (("set", "set", "s"), ("index", "roller", "s"), ("azimuth_deg", "azimuth deg", ".2f"))
        loads = (("load_N", "load N", ".3f"), ("largest_line_load_N_mm", "largest N/mm", ".3f"))
        races = [(f"{race} MPa", f"{race} MPa", ".0f") for race in RACES]
        flat = [r | {f"{race} MPa": r["pressure_MPa"][race] for race in RACES} for r in found]
        out.append(listed("rollers", (*names, *loads, *races), flat))
    return out


def _stiffness_lines(result: AxisResult) -> list[str]:
    if result.stiffness is None:
        return []
    d = np.diag(result.stiffness)
    words = [f"{n} {1e-6 * x:.5g} N/um" for n, x in zip(FREEDOMS[:3], d[:3], strict=True) if np.isfinite(x)]
    words += [f"{n} {1e-3 * x:.5g} kN m/rad" for n, x in zip(FREEDOMS[3:], d[3:], strict=True) if np.isfinite(x)]
    with np.errstate(all="ignore"):
        free = np.isfinite(d)
        C = np.linalg.inv(result.stiffness[np.ix_(free, free)])
    alone = dict(zip(np.array(FREEDOMS)[free], 1.0 / np.diag(C), strict=True))
    lone = [f"{n} {1e-6 * alone[n]:.5g} N/um" for n in FREEDOMS[:3] if n in alone]
    return [
        f"tangent stiffness of the whole, {result.stiffness_at}, the other freedoms held: {', '.join(words)}",
        f"the same, the other freedoms following: {', '.join(lone)}",
    ]
