"""A shaft with several rolling sets as one JSON object, and as tables to read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.comparison.commands.printing import Column
from rollbench.comparison.commands.solving.axis_summary import set_summary, whole_stiffness, whole_summary
from rollbench.comparison.commands.solving.solve_output import ball_rows as rows_of
from rollbench.comparison.commands.solving.solve_output import behind_json, first_lines, last_lines, solver_lines
from rollbench.comparison.commands.tables import listed, of_quantities
from rollbench.comparison.models.answers import AxisAnswers, SetAnswers
from rollbench.comparison.models.registry import random_errors
from rollbench.comparison.quantities import number, quantity
from rollbench.lowfi.statics.result import AxisResult, HousingResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import FREEDOMS, SIDES

if TYPE_CHECKING:
    from rich.console import RenderableType

#: Units of the six motions in results, and factors to them.
MOTION = (("ux_um", 1e6), ("uy_um", 1e6), ("uz_um", 1e6), ("rx_mrad", 1e3), ("ry_mrad", 1e3), ("rz_mrad", 1e3))
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


def _set(i: int, s: SetResult, answers: SetAnswers | None) -> dict[str, Any]:
    loads = s.loads
    return {
        "set": i + 1,
        "name": s.of.name,
        "kind": s.of.kind,
        "position_mm": number(1e3 * s.of.position),
        "housing": s.of.housing,
        "offset_um": number(1e6 * s.of.offset),
        "force_on_shaft_N": [number(x) for x in s.force],
        "moment_on_shaft_Nm": [number(x) for x in s.moment],
        "largest_load_N": number(loads.max(initial=0.0)),
        "loaded": int((loads > 0.0).sum()) if np.isfinite(loads).all() else None,
        "outer_motion": {name: number(f * x) for (name, f), x in zip(MOTION, s.outer, strict=True)},
        "stiffness": [[number(x) for x in row] for row in s.stiffness],
        "summary": set_summary(s, answers),
    }


def ball_rows(result: AxisResult) -> list[dict[str, Any]]:
    """One row per ball, numbered from 1 in each set."""
    of_balls = ((k, s.balls) for k, s in enumerate(result.sets, 1) if s.balls is not None)
    return [{"set": k} | row for k, balls in of_balls for row in rows_of(balls)]


def roller_rows(result: AxisResult) -> list[dict[str, Any]]:
    """One row per roller, numbered from 1 in each set."""
    return [
        {
            "set": k + 1,
            "index": i + 1,
            "azimuth_deg": number(math.degrees(azimuth)),
            "load_N": number(load),
            "largest_line_load_N_mm": number(1e-3 * s.line_loads[i].max()),
        }
        for k, s in enumerate(result.sets)
        if s.roller_azimuth is not None and s.roller_load is not None and s.line_loads is not None
        for i, (azimuth, load) in enumerate(zip(s.roller_azimuth, s.roller_load, strict=True))
    ]


def _housing(h: HousingResult) -> dict[str, Any]:
    return {
        "name": h.name,
        "motion": {name: number(f * x) for (name, f), x in zip(MOTION, h.motion, strict=True)},
        "frame_force_N": [number(x) for x in h.wrench[:3]],
        "frame_moment_Nm": [number(x) for x in h.wrench[3:]],
        "residual": number(h.residual),
    }


def as_json(assembly: Assembly, result: AxisResult, answers: AxisAnswers | None = None, member: int = 0) -> dict[str, Any]:
    """The result as a JSON-ready object in the keys of a single set's; rows of balls and rollers begin with their set, sums
    of a set are in ``sets``; answers: what else stands in the summaries."""
    of_sets = (None,) * len(result.sets) if answers is None else answers.sets
    return {
        "scene": assembly.name,
        "kind": assembly.kind,
        "model": result.model,
        "member": member if random_errors(assembly) else None,
        "status": result.status,
        "sets": [_set(i, s, x) for i, (s, x) in enumerate(zip(result.sets, of_sets, strict=True))],
        "balls": ball_rows(result),
        "rollers": roller_rows(result),
        "summary": whole_summary(result, answers),
        "housings": [_housing(h) for h in result.housings],
        "stiffness": whole_stiffness(result),
        **behind_json(result),
    }


def as_table(
    assembly: Assembly, result: AxisResult, *, block: str = "", balls: bool = True, details: bool = True
) -> list[RenderableType]:
    """The result for the terminal: block of answers, sets, balls and rollers where asked for, housings, stiffness,
    warnings; solver and assumptions, or where they are."""
    parts: list[Any] = [
        f"{assembly.name}, {len(assembly.sets)} sets, model {result.model}: {result.status}",
        assembly.title,
        *first_lines(result, block),
    ]
    if result.sets and result.converged:
        parts += [of_quantities("sets: force on the shaft, stiffness of the set alone", SETS, result.sets)]
        parts += _element_tables(result) if balls else []
    for h in result.housings if result.converged else ():
        moved = ", ".join(
            f"{n.split('_')[0]} {f * x:.4g} {n.split('_')[1]}" for (n, f), x in zip(MOTION, h.motion, strict=True)
        )
        force = ", ".join(f"{x:.5g}" for x in h.wrench[:3])
        parts.append(f"{h.name}: {moved}; the frame holds it with ({force}) N; balance {h.residual:.1e}")
    parts += _stiffness_lines(result)
    e = result.equilibrium
    behind = solver_lines(result.solver)
    if e is not None:
        balance = f"balance of the shaft: force {e.force_residual:.1e}, moment {e.moment_residual:.1e} (relative)"
        behind = [balance, *behind]
    return [*parts, *last_lines(result, behind, details=details or not block)]


def _element_tables(result: AxisResult) -> list[RenderableType]:
    """Balls by set and index, with the sides that carry load; rollers."""
    out: list[RenderableType] = []
    rows = ball_rows(result)
    shown = [s for s in SIDES if any((r["load_N"][s] or 0.0) > 0.0 for r in rows)]
    if rows and shown:
        columns: list[Column] = [("set", "set", "s"), ("index", "ball", "s"), ("azimuth_deg", "azimuth deg", ".2f")]
        for side in shown:
            columns += [(f"{side} N", f"{side} N", ".3f"), (f"{side} deg", "angle deg", ".3f")]
        flat = [
            r | {f"{s} N": r["load_N"][s] for s in shown} | {f"{s} deg": r["contact_angle_deg"][s] for s in shown}
            for r in rows
        ]
        out.append(listed("balls", columns, flat))
    rollers = roller_rows(result)
    if rollers:
        names = (("set", "set", "s"), ("index", "roller", "s"), ("azimuth_deg", "azimuth deg", ".2f"))
        loads = (("load_N", "load N", ".3f"), ("largest_line_load_N_mm", "largest N/mm", ".3f"))
        out.append(listed("rollers", (*names, *loads), rollers))
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
