"""``rollbench solve`` of several rolling sets on one shaft."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.comparison.commands.printing import Answer, text_width
from rollbench.comparison.commands.solving.axis_output import as_json, as_table
from rollbench.comparison.commands.solving.axis_summary import block
from rollbench.comparison.commands.solving.load_curve import FACTORS, write_rows
from rollbench.comparison.commands.solving.matrix_files import write_stiffness
from rollbench.comparison.commands.solving.solve_choices import Choices
from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.loads_file import loads_csv, write_loads
from rollbench.comparison.models.axis_answers import curve, solve_sets
from rollbench.lowfi.statics.result import AxisResult
from rollbench.lowfi.warned import above
from rollbench.meshes.axis import Assembly


def solve_axis(assembly: Assembly, choices: Choices, station: float) -> Answer:
    """Solve an assembly; exit code 1 where it did not converge.

    station [m]: of ``--stiffness-at``. Raises InputError for what does not fit, and for a model that knows one set only.
    """
    _check(assembly, choices, station)
    if choices.stiffness_at:
        assembly = replace(assembly, stiffness_at=station)
    result, found = solve_sets(assembly, choices.model, choices.member)
    written = _write(assembly, result, choices) if result.converged else []
    text = "" if found is None else block(assembly, result, found, text_width())
    parts = [*as_table(assembly, result, block=text, balls=choices.balls, details=choices.assumptions), *written]
    code = 1 if not result.converged or (choices.strict and above(result.warnings)) else 0
    return Answer(as_json(assembly, result, found, choices.member), parts, code, folded=True)


def _check(assembly: Assembly, choices: Choices, station: float) -> None:
    """Refuse what several sets do not have."""
    refused = (
        ("--all", choices.everything, "every set is built as its scene asks: leave it out"),
        ("--condensed", choices.condensed, "a file of condensed bodies holds those of one set: leave it out"),
    )
    for option, value, advice in refused:
        if value:
            raise InputError("command line", option, f"with {assembly.name}", "one set on a shaft", advice)
    if choices.stiffness_at and not 0.0 <= station <= assembly.screw.length:
        allowed = f"0 mm to {1e3 * assembly.screw.length:g} mm"
        raise InputError("command line", "--stiffness-at", choices.stiffness_at, allowed, "give a station of the shaft")


def _write(assembly: Assembly, result: AxisResult, choices: Choices) -> list[str]:
    """Files that were asked for; lines that say so."""
    lines = []
    if choices.matrix is not None:
        K = result.stiffness
        if K is None or not np.isfinite(K).all():
            advice = "ask for a station where no freedom of the shaft is held"
            raise InputError("command line", "--matrix", str(choices.matrix), "a stiffness in all six freedoms", advice)
        words = f"{result.stiffness_at} against all that the scene holds"
        write_stiffness(choices.matrix, K, f"tangent stiffness of {assembly.name}, model {result.model}, {words}")
        lines.append(f"wrote {choices.matrix}: the matrix, symmetric, in N, m and rad")
    if choices.curve is not None:
        lines += write_axis_curve(choices.curve, assembly, result.model, choices.member)
    if choices.loads_csv is not None:
        sets = [(k, s.balls) for k, s in enumerate(result.sets, 1) if s.balls is not None]
        rows = [{"set": str(k)} | row for k, b in sets for row in loads_csv(b.load, b.azimuth, b.z)]
        if not rows:
            advice = "rollers have no flanks: leave it out"
            raise InputError("command line", "--loads-csv", str(choices.loads_csv), "a set of balls", advice)
        lines.append(write_loads(choices.loads_csv, rows))
    return lines


def write_axis_curve(path: Path, assembly: Assembly, model: str, member: int = 0) -> list[str]:
    """The table and figure of ``--curve``: what is asked about, over the loads on shaft and housings; lines that say so.

    Torque is left to ``rollbench friction``. Raises InputError for a scene without axial load.
    """
    points = curve(assembly, FACTORS, model, member)
    if len(points) < 3 or max(abs(p.force) for p in points) == 0.0:
        allowed = "a scene that solves under parts of its axial load"
        raise InputError("command line", "--curve", str(path), allowed, "give shaft or housing an axial load")
    rows: list[dict[str, float | None]] = [
        {
            "load_factor": p.factor,
            "axial_force_N": p.force,
            "displacement_um": 1e6 * p.displacement,
            "stiffness_N_per_um": 1e-6 * p.stiffness if np.isfinite(p.stiffness) else None,
            "largest_load_N": p.largest,
            "torque_Nmm": None,
        }
        for p in points
    ]
    return write_rows(path, assembly.name, rows, "axial force on shaft and housings / kN")
