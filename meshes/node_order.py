"""Conversion of the node order of finite element cells from gmsh to VTK and meshio."""

from __future__ import annotations

#: For each element type, its name in meshio, and the number in gmsh's cell of each node of VTK's cell (checked by tests).
VTK: dict[str, tuple[str, tuple[int, ...]]] = {
    "P1": ("tetra", tuple(range(4))),
    "P2": ("tetra10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    "Q1": ("hexahedron", tuple(range(8))),
    "Q2": ("hexahedron27", (*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26)),
}
