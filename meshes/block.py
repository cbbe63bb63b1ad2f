"""Blocks for the verification of contact: a quarter of a half-space, fine at the contact, as hexahedra or tetrahedra.

The body fills z > 0 below the contact plane z = 0; x = 0 and y = 0 are planes of symmetry through the contact's centre,
and the block is cut off at x, y, z = size.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from skfem import Mesh

from rollbench.meshes.arrays import Array
from rollbench.meshes.fem import Meshed, kind_of, mesh_of, points_of, tensor_grid, with_boundaries, with_points
from rollbench.meshes.shell import gmsh_session


@dataclass(frozen=True)
class BlockMesh(Meshed):
    """A quarter block.

    Boundaries: "contact" (the plane z = 0), "x = 0" and "y = 0" (the planes of symmetry), "cut" (where the block is cut
    off).
    """

    #: The mesh.
    mesh: Mesh
    #: Edge of the block [m].
    size: float

    @property
    def element(self) -> str:
        """Kind of its cells: P1, P2, Q1 or Q2."""
        return kind_of(self.mesh)


def graded_coordinates(cell: float, core: float, size: float, growth: float) -> Array:
    """Corner coordinates from 0 to an end: equal cells over a core, then growing ones.

    Parameters
    ----------
    cell : float
        First cell [m].
    core : float
        Length that the equal cells cover at least [m].
    size : float
        End [m].
    growth : float
        Largest ratio of neighbouring cells, > 1.

    Returns
    -------
    (m + 1,) Array
        Coordinates [m].

    Raises
    ------
    ValueError
        Unless 0 < cell <= size, core < size and growth > 1.

    Examples
    --------
    >>> graded_coordinates(1.0, 2.0, 9.0, 2.0).round(3).tolist()
    [0.0, 1.0, 2.0, 3.488, 5.703, 9.0]
    """
    if not (0.0 < cell <= size and core < size and growth > 1.0):
        raise ValueError(f"cells of {cell} m, core {core} m, block {size} m, growth {growth}: see the ranges allowed")
    equal = int(np.ceil(core / cell - 1e-9))
    room = size - equal * cell
    count = 1
    while cell * growth * (growth**count - 1.0) / (growth - 1.0) < room:
        count += 1
    steps = growth ** np.arange(1, count + 1)
    low, high = 0.0, growth
    for _ in range(80):  # the ratio at which the cells end at `size`
        ratio = 0.5 * (low + high)
        steps = cell * ratio ** np.arange(1, count + 1)
        low, high = (ratio, high) if steps.sum() < room else (low, ratio)
    out = np.concatenate([cell * np.arange(equal + 1), equal * cell + np.cumsum(steps)])
    out[-1] = size
    return out


def hexahedral_block(order: int, spacing: Sequence[float], core: Sequence[float], size: float, growth: float) -> BlockMesh:
    """Tensor-graded hexahedra with 8 or 27 nodes.

    Parameters
    ----------
    order : int
        1 or 2.
    spacing : Sequence[float]
        Distance of the nodes in the core along x, y, z [m]; cells are ``order`` times as long.
    core : Sequence[float]
        Length of the equal cells along x, y, z [m].
    size : float
        Edge of the block [m].
    growth : float
        Largest ratio of neighbouring cells outside the core.

    Returns
    -------
    BlockMesh
        The block.

    Raises
    ------
    ValueError
        As `graded_coordinates`.
    """
    x, y, z = (graded_coordinates(order * step, length, size, growth) for step, length in zip(spacing, core, strict=True))
    return _name_boundaries(tensor_grid(x, y, z, f"Q{order}"), size)


@dataclass(frozen=True)
class Influence:
    """Body of influence: size of the cells in and around an ellipsoid about the contact."""

    #: Edge of the cells in the ellipsoid [m].
    fine: float
    #: Semi-axes of the ellipsoid along x, y, z [m].
    semi: tuple[float, float, float]
    #: Growth of the edge per unit of distance outside.
    growth: float
    #: Largest edge [m].
    coarse: float

    def scaled(self, factor: float) -> Influence:
        """Copy with all lengths multiplied by a factor."""
        x, y, z = (factor * length for length in self.semi)
        return replace(self, fine=factor * self.fine, semi=(x, y, z), coarse=factor * self.coarse)

    def expression(self) -> str:
        """Edge as a formula for gmsh; distance is that of the ellipsoid through the point, along its short axis."""
        x, y, z = self.semi
        away = f"({min(self.semi)!r}*Max(0, Sqrt((x/{x!r})^2+(y/{y!r})^2+(z/{z!r})^2)-1))"
        return f"Min({self.coarse!r}, {self.fine!r}+{self.growth!r}*{away})"


def tetrahedral_block(order: int, influence: Influence, size: float) -> BlockMesh:
    """Graded tetrahedra with 4 or 10 nodes, by gmsh.

    Parameters
    ----------
    order : int
        1 or 2.
    influence : Influence
        Edges of the cells.
    size : float
        Edge of the block [m].

    Returns
    -------
    BlockMesh
        The block.

    Raises
    ------
    ImportError
        gmsh, or a system library that it needs, is missing.
    """
    with gmsh_session() as gmsh:
        gmsh.model.add("block")
        gmsh.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)  # OpenCASCADE's tolerances suit lengths about 1
        gmsh.model.occ.synchronize()
        _set_edges(gmsh, influence.scaled(1.0 / size))
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        ascending = np.argsort(tags)
        _, nodes = gmsh.model.mesh.getElementsByType({1: 4, 2: 11}[order])
        gmsh.model.remove()
    cells = np.searchsorted(tags[ascending], nodes).reshape(-1, {1: 4, 2: 10}[order])
    mesh, _ = mesh_of(xyz.reshape(-1, 3)[ascending], cells, f"P{order}")
    return _name_boundaries(with_points(mesh, size * points_of(mesh)), size)


def _name_boundaries(mesh: Mesh, size: float) -> BlockMesh:
    """Name the boundaries of a block."""

    def on(axis: int, place: float) -> Callable[[Array], Array]:
        return lambda x: np.abs(x[axis] - place) < 1e-9 * size

    faces = {"contact": on(2, 0.0), "x = 0": on(0, 0.0), "y = 0": on(1, 0.0)}
    facets = {name: mesh.facets_satisfying(test, boundaries_only=True) for name, test in faces.items()}
    cut = [mesh.facets_satisfying(on(axis, size), boundaries_only=True) for axis in range(3)]
    return BlockMesh(with_boundaries(mesh, {**facets, "cut": np.unique(np.concatenate(cut))}), size)


def _set_edges(gmsh: Any, influence: Influence) -> None:
    """Let only the body of influence rule the edges."""
    field = gmsh.model.mesh.field.add("MathEval")
    gmsh.model.mesh.field.setString(field, "F", influence.expression())
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{name}", 0)
