"""Files of a solved scene: its stiffness matrix for other programs, and what it answers over its load."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import need_writable, replace_file, write_csv, write_figure
from rollbench.compare.models.answers import quick_friction
from rollbench.compare.models.loading import CurvePoint, curve
from rollbench.compare.models.registry import Options
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Series

#: Grid point and name of the matrix in DMIG cards.
GRID, NAME = 1, "KNUT"
#: Factors on the scene's loads.
FACTORS = tuple(round(0.1 * k, 1) for k in range(16))
COLUMNS = ("load_factor", "axial_force_N", "displacement_um", "stiffness_N_per_um", "largest_load_N", "torque_Nmm")


def check_matrix(path: Path) -> None:
    """Raises InputError for a name that says no format, or a file that cannot be written."""
    if path.suffix.lower() not in (".mtx", ".dmig"):
        allowed = "a name that ends in .mtx (Matrix Market) or .dmig (Nastran)"
        raise ArgumentError("matrix", str(path), allowed, "rename it")
    need_writable(path)


def write_stiffness(path: Path, matrix: Array, words: str) -> None:
    """Write a stiffness (6, 6) in the format of the file's name, with words for what it is."""
    comment = re.sub(r"[^ -~]", "?", f"rollbench: {words}; ux uy uz rx ry rz; N, m, rad")
    replace_file(path, market(matrix, comment) if path.suffix.lower() == ".mtx" else dmig(matrix, comment))


def market(matrix: Array, comment: str) -> str:
    """Matrix Market text of a symmetric matrix."""
    from scipy.io import mmwrite

    stream = io.BytesIO()
    mmwrite(stream, matrix, comment=comment, symmetry="symmetric", precision=16)
    return stream.getvalue().decode("ascii")


def dmig(matrix: Array, comment: str) -> str:
    """DMIG cards in large fields (16 columns) of a symmetric ``(6, 6)`` matrix at one grid point: lower triangle, real,
    double precision."""
    lines = [f"$ {comment[i : i + 70]}" for i in range(0, len(comment), 70)]
    lines.append(f"{'DMIG':<8}{NAME:<8}{0:>8}{6:>8}{2:>8}{0:>8}")
    for column in range(6):
        lines.append(f"{'DMIG*':<8}{NAME:<16}{GRID:>16}{column + 1:>16}{'':16}*")
        for row in range(column, 6):
            value = f"{matrix[row, column]:.9E}".replace("E", "D")
            lines.append(f"{'*':<8}{GRID:>16}{row + 1:>16}{value:>16}{'':16}{'*' if row < 5 else ''}".rstrip())
    return "\n".join(lines) + "\n"


def write_curve(path: Path, scene: Scene | Assembly, model: str, options: Options) -> list[str]:
    """Solve at 0 to 1.5 times the loads and write the table and, beside it, the figure (SVG); lines that say so.

    Raises InputError for a scene without axial load, and where a file cannot be written.
    """
    points = curve(scene, FACTORS, model, options)
    several = isinstance(scene, Assembly)
    if len(points) < 3 or max(abs(p.force) for p in points) == 0.0:
        allowed = "a scene that solves under parts of its axial load"
        advice = f"give {'shaft or housing' if several else 'the scene'} an axial load"
        raise ArgumentError("curve", str(path), allowed, advice)
    name, over = scene.name, f"axial force on {'shaft and housings' if several else 'the nut'} / kN"
    rows = curve_rows(scene, points, options)
    write_csv(path, rows)
    picture = write_figure(path.with_suffix(".svg"), curve_figure(name, rows, over))
    missing = len(FACTORS) - len(rows)
    left = f"; {missing} of {len(FACTORS)} loads without a solution are left out" if missing else ""
    if all(row["torque_Nmm"] is None for row in rows):
        left += "; no torque: the scene has no coefficient of friction, or rollbench friction never ran here"
    return [f"wrote {path} and {picture}: {len(rows)} loads from 0 to {rows[-1]['load_factor']:g} times the scene's{left}"]


def curve_rows(scene: Scene | Assembly, points: list[CurvePoint], options: Options) -> list[dict[str, float | None]]:
    """Rows of the table. Stiffness of one set by differences along the curve, torque where the scene has a coefficient and
    no kernel has to be compiled for it; of several sets the tangent, torque is left to ``rollbench friction``."""
    force = np.array([p.force for p in points])
    moved = np.array([p.displacement for p in points])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = 1.0 / np.gradient(moved, force)
    rows = []
    for p, k in zip(points, slope, strict=True):
        friction = None
        if isinstance(p.result, AxisResult):
            k = np.nan if p.result.stiffness is None else p.result.stiffness[2, 2]
        elif isinstance(scene, Scene) and p.largest > 0.0:
            friction, _ = quick_friction(scene, p.result, options)
        torque = None if friction is None else friction["friction_torque_Nmm"]
        stiffness = 1e-6 * float(k) if np.isfinite(k) else None
        values = (p.factor, p.force, 1e6 * p.displacement, stiffness, p.largest, torque)
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def curve_figure(name: str, rows: list[dict[str, float | None]], over: str) -> Figure:
    """A panel for each column that has values."""
    labels = {
        "displacement_um": "axial displacement / µm",
        "stiffness_N_per_um": "tangent stiffness / (N/µm)",
        "largest_load_N": "largest contact load / N",
        "torque_Nmm": "friction torque / (N mm)",
    }
    panels = []
    for column, label in labels.items():
        known = [(1e-3 * float(r["axial_force_N"] or 0.0), float(v)) for r in rows if (v := r[column]) is not None]
        if known:
            x, y = zip(*known, strict=True)
            series = Series(name, x, y)
            panels.append(Panel(label.split(" /")[0], over, label, [series], zero=True))
    return Figure("load-curve", f"{name} over its load", panels)
