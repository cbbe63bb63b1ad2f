"""A stiffness matrix as a file for other programs: Matrix Market, or DMIG cards of Nastran bulk data."""

from __future__ import annotations

import io
import re
from pathlib import Path

from rollbench.comparison.errors import InputError
from rollbench.comparison.writing import need_writable, replace_file
from rollbench.meshes.arrays import Array

#: Grid point and name of the matrix in DMIG cards.
GRID, NAME = 1, "KNUT"


def check_matrix(path: Path) -> None:
    """Raises InputError for a name that says no format, or a file that cannot be written."""
    if path.suffix.lower() not in (".mtx", ".dmig"):
        allowed = "a name that ends in .mtx (Matrix Market) or .dmig (Nastran)"
        raise InputError("command line", "--matrix", str(path), allowed, "rename it")
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
