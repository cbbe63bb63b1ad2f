"""What ``rollbench solve`` refuses and writes of several rolling sets on one shaft."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rollbench.comparison.commands.solving.load_curve import FACTORS, write_rows
from rollbench.comparison.commands.solving.matrix_files import write_stiffness
from rollbench.comparison.commands.solving.solve_choices import Choices
from rollbench.comparison.errors import InputError
from rollbench.comparison.models.axis_answers import curve
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.axis import Assembly


def check(assembly: Assembly, choices: Choices) -> None:
    """Refuse what several sets do not have."""
    refused = (
        ("--all", choices.everything, "every set is built as its scene asks: leave it out"),
        ("--condensed", choices.condensed, "a file of condensed bodies holds those of one set: leave it out"),
    )
    for option, value, advice in refused:
        if value:
            raise InputError("command line", option, f"with {assembly.name}", "one set on a shaft", advice)
    if choices.loads_csv is not None and not assembly.ball_count:
        advice = "rollers have no flanks: leave it out"
        raise InputError("command line", "--loads-csv", str(choices.loads_csv), "a set of balls", advice)


def write(assembly: Assembly, result: AxisResult, choices: Choices) -> list[str]:
    """Files that were asked for, but of loads; lines that say so. Raises InputError."""
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
