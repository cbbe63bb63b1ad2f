"""Files that ``rollbench solve`` writes: the stiffness matrix for other programs, and the load curve."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import need_writable, replace_file, write_csv, write_figure
from rollbench.compare.quantities import as_json
from rollbench.compare.results.load_curve import LoadCurve
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Series

#: Number of the grid point, and name of the matrix, in DMIG cards of Nastran.
GRID, NAME = 1, "KNUT"


def check_matrix(path: Path) -> None:
    """Raise InputError if the suffix of a file for a stiffness matrix is unknown, or if the file cannot be written."""
    if path.suffix.lower() not in (".mtx", ".dmig"):
        allowed = "a name that ends in .mtx (Matrix Market) or .dmig (Nastran)"
        raise ArgumentError("matrix", str(path), allowed, "change the suffix of the file")
    need_writable(path)


def write_stiffness(path: Path, matrix: Array, words: str) -> None:
    """Write a stiffness matrix (6, 6) in the format that the suffix of the file names, with ``words`` as comment."""
    comment = re.sub(r"[^ -~]", "?", f"rollbench: {words}; ux uy uz rx ry rz; N, m, rad")
    replace_file(path, matrix_market_text(matrix, comment) if path.suffix.lower() == ".mtx" else dmig_text(matrix, comment))


def matrix_market_text(matrix: Array, comment: str) -> str:
    """Return the text of a symmetric matrix in the Matrix Market format."""
    from scipy.io import mmwrite

    stream = io.BytesIO()
    mmwrite(stream, matrix, comment=comment, symmetry="symmetric", precision=16)
    return stream.getvalue().decode("ascii")


def dmig_text(matrix: Array, comment: str) -> str:
    """Return the text of DMIG cards (Nastran) with a symmetric ``(6, 6)`` matrix at one grid point.

    The cards have the lower triangle in double precision, in large fields of 16 columns.
    """
    lines = [f"$ {comment[i : i + 70]}" for i in range(0, len(comment), 70)]
    lines.append(f"{'DMIG':<8}{NAME:<8}{0:>8}{6:>8}{2:>8}{0:>8}")
    for column in range(6):
        lines.append(f"{'DMIG*':<8}{NAME:<16}{GRID:>16}{column + 1:>16}{'':16}*")
        for row in range(column, 6):
            value = f"{matrix[row, column]:.9E}".replace("E", "D")
            lines.append(f"{'*':<8}{GRID:>16}{row + 1:>16}{value:>16}{'':16}{'*' if row < 5 else ''}".rstrip())
    return "\n".join(lines) + "\n"


def write_curve(path: Path, curve: LoadCurve) -> list[str]:
    """Write the points of a load curve (CSV) and its figure (SVG), and return a line that names both files.

    InputError if a file cannot be written.
    """
    rows = [as_json(point) or {} for point in curve.points]
    write_csv(path, rows)
    picture = write_figure(path.with_suffix(".svg"), curve_figure(curve, rows))
    return [f"wrote {path} and {picture}"]


def curve_figure(curve: LoadCurve, rows: list[dict[str, Any]]) -> Figure:
    """Return the figure of a load curve, with a panel over the load for each quantity that has values."""
    labels = {
        "displacement_um": "displacement / µm",
        "stiffness_N_per_um": "tangent stiffness / (N/µm)",
        "largest_load_N": "largest contact load / N",
        "friction_torque_Nmm": "friction torque / (N mm)",
    }
    panels = []
    for column, label in labels.items():
        known = [(1e-3 * row["load_N"], row[column]) for row in rows if row[column] is not None]
        if known:
            x, y = zip(*known, strict=True)
            panels.append(Panel(label.split(" /")[0], "load / kN", label, [Series(curve.scene, x, y)], zero=True))
    return Figure("load-curve", f"{curve.scene} over its load", panels)
