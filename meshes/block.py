"""Meshes of a quarter block for verifying contact solutions on a half-space: hexahedra or tetrahedra, fine at the contact.

The block fills z > 0; z = 0 is the contact plane. x = 0 and y = 0 are planes of symmetry through the centre of the contact,
and the half-space is cut off at the planes x = size, y = size and z = size, with the block's edge ``size``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from skfem import Mesh

from rollbench.meshes import fem
from rollbench.meshes.arrays import Array
from rollbench.meshes.shell import gmsh_session, set_element_size_formula, take_nodes_and_cells


@dataclass(frozen=True)
class QuarterBlockMesh(fem.MeshedBody):
    """Mesh of a quarter of a block that stands for an elastic half-space in contact.

    Names of boundaries: "contact" (the plane z = 0), "x = 0" and "y = 0" (the planes of symmetry), "cut" (the planes where
    the half-space is cut off).
    """

    @property
    def element(self) -> str:
        """Element type of the mesh: P1, P2, Q1 or Q2."""
        return fem.element_type_of_mesh(self.mesh)


def graded_coordinates(cell_length: float, fine_length: float, block_edge: float, growth_ratio: float) -> Array:
    """Return the grid coordinates along one axis of a block: equal cells near 0, then cells of increasing length.

    Parameters
    ----------
    cell_length : float
        Length of the equal cells [m].
    fine_length : float
        Length, measured from 0, that the equal cells must at least cover [m].
    block_edge : float
        Last coordinate, the edge of the block [m].
    growth_ratio : float
        Largest ratio of the lengths of neighbouring cells, above 1.

    Returns
    -------
    (m + 1,) Array
        Coordinates [m].

    Raises
    ------
    ValueError
        Unless 0 < cell_length <= block_edge, fine_length < block_edge and growth_ratio > 1.

    Examples
    --------
    >>> graded_coordinates(1.0, 2.0, 9.0, 2.0).round(3).tolist()
    [0.0, 1.0, 2.0, 3.488, 5.703, 9.0]
    """
    if not (0.0 < cell_length <= block_edge and fine_length < block_edge and growth_ratio > 1.0):
        raise ValueError(
            f"no mesh with cell_length {cell_length} m, fine_length {fine_length} m, block_edge {block_edge} m and "
            f"growth_ratio {growth_ratio}: choose 0 < cell_length <= block_edge, fine_length < block_edge and "
            "growth_ratio > 1"
        )
    equal = int(np.ceil(fine_length / cell_length - 1e-9))
    room = block_edge - equal * cell_length
    count = 1
    while cell_length * growth_ratio * (growth_ratio**count - 1.0) / (growth_ratio - 1.0) < room:
        count += 1
    steps = growth_ratio ** np.arange(1, count + 1)
    low, high = 0.0, growth_ratio
    for _ in range(80):  # bisection for the ratio at which the last cell ends at `block_edge`
        ratio = 0.5 * (low + high)
        steps = cell_length * ratio ** np.arange(1, count + 1)
        low, high = (ratio, high) if steps.sum() < room else (low, ratio)
    out = np.concatenate([cell_length * np.arange(equal + 1), equal * cell_length + np.cumsum(steps)])
    out[-1] = block_edge
    return out


def mesh_block_with_hexahedra(
    order: int, node_spacing: Sequence[float], fine_lengths: Sequence[float], block_edge: float, growth_ratio: float
) -> QuarterBlockMesh:
    """Mesh a quarter block with hexahedra of 8 or 27 nodes on a rectangular grid, fine at the contact.

    Parameters
    ----------
    order : int
        Order of the elements: 1 (8 nodes) or 2 (27 nodes).
    node_spacing : Sequence[float]
        Distance between nodes near the contact along x, y, z [m]; cells are ``order`` times as long.
    fine_lengths : Sequence[float]
        Length that the equal cells near the contact cover along x, y, z [m].
    block_edge : float
        Edge of the block [m].
    growth_ratio : float
        Largest ratio of the lengths of neighbouring cells further away.

    Returns
    -------
    QuarterBlockMesh
        Mesh of the block.

    Raises
    ------
    ValueError
        The lengths or the growth are not in the range of `graded_coordinates`.
    """
    x, y, z = (
        graded_coordinates(order * step, length, block_edge, growth_ratio)
        for step, length in zip(node_spacing, fine_lengths, strict=True)
    )
    return _block_with_named_boundaries(fem.mesh_rectangular_grid(x, y, z, f"Q{order}"), block_edge)


@dataclass(frozen=True)
class EllipsoidElementSizes:
    """Edge lengths of tetrahedra: constant inside an ellipsoid around the contact, growing with the distance outside it."""

    #: Edge length of the cells inside the ellipsoid [m].
    inner_edge_length: float
    #: Semi-axes of the ellipsoid along x, y, z [m].
    semi_axes: tuple[float, float, float]
    #: Increase of the edge length per unit of distance outside the ellipsoid.
    growth_per_distance: float
    #: Largest edge length, far from the ellipsoid [m].
    largest_edge_length: float

    def edge_length_formula(self, factor: float) -> str:
        """Return the edge length as a formula of x, y, z for gmsh, for all lengths multiplied by ``factor``.

        Outside the ellipsoid the length grows with the distance, measured along the shortest semi-axis, between the
        ellipsoid and the similar ellipsoid through the point.
        """
        x, y, z = (factor * length for length in self.semi_axes)
        away = f"({min(x, y, z)!r}*Max(0, Sqrt((x/{x!r})^2+(y/{y!r})^2+(z/{z!r})^2)-1))"
        inner, largest = factor * self.inner_edge_length, factor * self.largest_edge_length
        return f"Min({largest!r}, {inner!r}+{self.growth_per_distance!r}*{away})"


def mesh_block_with_tetrahedra(order: int, element_sizes: EllipsoidElementSizes, block_edge: float) -> QuarterBlockMesh:
    """Mesh a quarter block with tetrahedra of 4 or 10 nodes by gmsh, fine at the contact.

    Parameters
    ----------
    order : int
        Order of the elements: 1 (4 nodes) or 2 (10 nodes).
    element_sizes : EllipsoidElementSizes
        Edge lengths of the tetrahedra inside and outside the ellipsoid around the contact.
    block_edge : float
        Edge of the block [m].

    Returns
    -------
    QuarterBlockMesh
        Mesh of the block.

    Raises
    ------
    ImportError
        gmsh, or a system library that it needs, is missing.
    """
    with gmsh_session() as gmsh:
        gmsh.model.add("block")
        gmsh.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)  # OpenCASCADE's tolerances are made for lengths of about 1
        gmsh.model.occ.synchronize()
        set_element_size_formula(gmsh, element_sizes.edge_length_formula(1.0 / block_edge))
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        points, cells = take_nodes_and_cells(gmsh, *{1: (4, 4), 2: (11, 10)}[order])
    mesh, _ = fem.build_mesh(points, cells, f"P{order}")
    scaled = fem.with_node_coordinates(mesh, block_edge * fem.node_coordinates(mesh))
    return _block_with_named_boundaries(scaled, block_edge)


def _block_with_named_boundaries(mesh: Mesh, size: float) -> QuarterBlockMesh:
    """Return the mesh of a quarter block with its named boundaries, found from the nodes' coordinates.

    ``size``: edge of the block [m].
    """

    def lies_on_plane(axis: int, place: float) -> Callable[[Array], Array]:
        return lambda x: np.abs(x[axis] - place) < 1e-9 * size

    faces = {"contact": lies_on_plane(2, 0.0), "x = 0": lies_on_plane(0, 0.0), "y = 0": lies_on_plane(1, 0.0)}
    facets = {name: mesh.facets_satisfying(test, boundaries_only=True) for name, test in faces.items()}
    cut = [mesh.facets_satisfying(lies_on_plane(axis, size), boundaries_only=True) for axis in range(3)]
    return QuarterBlockMesh(fem.with_boundaries_from_facets(mesh, {**facets, "cut": np.unique(np.concatenate(cut))}))
