"""Meshes out of gmsh as plain arrays, onward to scikit-fem and to files; nothing with a name is lost on the way.

Arrays come from gmsh's API, not from a file: scikit-fem 12.0.2 silently drops the named boundaries of second-order
meshes that it reads through meshio. Node order is gmsh's; it is permuted here, once, for scikit-fem and for VTK.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

VOLUMES = {4: "P1", 11: "P2", 5: "Q1", 12: "Q2"}
"""Volume elements by gmsh's element type."""
_NODES = {"P1": 4, "P2": 10, "Q1": 8, "Q2": 27}
_CORNERS = {"P1": 4, "P2": 4, "Q1": 8, "Q2": 8}
_TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
_HEXAHEDRON = ((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7))

# Place k of the other program's cell holds gmsh's local node; by matching coordinates (see the tests).
_SKFEM: dict[str, tuple[int, ...]] = {
    "P1": tuple(range(4)),
    "P2": (0, 1, 2, 3, 4, 5, 6, 7, 9, 8),
    "Q1": (6, 2, 5, 7, 1, 3, 4, 0),
    "Q2": (6, 2, 5, 7, 1, 3, 4, 0, 14, 18, 19, 11, 13, 12, 16, 15, 17, 8, 9, 10, 23, 25, 24, 21, 20, 22, 26),
}
_VTK: dict[str, tuple[str, tuple[int, ...]]] = {
    "P1": ("tetra", tuple(range(4))),
    "P2": ("tetra10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    "Q1": ("hexahedron", tuple(range(8))),
    "Q2": (
        "hexahedron27",
        (*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26),
    ),
}


@dataclass(frozen=True, eq=False)
class MeshData:
    """A volume mesh.

    points: shape (n, 3) [m]; cells: node indices (m, nodes) by element name (P1, P2, Q1, Q2), gmsh's node order;
    regions: cell numbers by name, counted through `cells` in its order; boundaries: faces (k, nodes of a face) by name.
    """

    points: FloatArray
    cells: dict[str, IntArray]
    regions: dict[str, IntArray] = field(default_factory=dict)
    boundaries: dict[str, IntArray] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of cells of all elements."""
        return sum(len(c) for c in self.cells.values())


def from_gmsh(regions: Iterable[str] = (), boundaries: Iterable[str] = ()) -> MeshData:
    """The mesh of gmsh's current model: all volume cells, and the physical groups of volumes and surfaces by name.

    Nodes that no cell uses are left out. regions, boundaries: names that must be there.
    Raises ValueError for an expected name that is missing, a physical group without a name, without elements or with
    elements other than P1, P2, Q1, Q2 and their faces, and for a boundary face that is not the face of a cell.
    """
    import gmsh

    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    order = np.argsort(tags)
    sorted_tags = np.asarray(tags, dtype=np.int64)[order]
    points = np.asarray(coordinates, dtype=float).reshape(-1, 3)[order]
    types, elements, nodes = mesh.getElements(3)
    _known(types, "the mesh")
    cells: dict[str, IntArray] = {}
    numbers = []
    for kind, element_tags, node_tags in zip(types, elements, nodes, strict=True):
        name = VOLUMES[int(kind)]
        cells[name] = np.searchsorted(sorted_tags, np.asarray(node_tags, dtype=np.int64)).reshape(-1, _NODES[name])
        numbers.append(np.asarray(element_tags, dtype=np.int64))
    if not cells:
        raise ValueError("gmsh's current model has no volume cells: call gmsh.model.mesh.generate(3) first")
    all_numbers = np.concatenate(numbers)
    place = np.argsort(all_numbers)
    found_regions = {}
    for name, entities in _groups(3).items():
        wanted = _elements_of(entities, 3, f"region {name!r}")[0]
        found_regions[name] = np.sort(place[np.searchsorted(all_numbers, wanted, sorter=place)])
    found_boundaries = {}
    for name, entities in _groups(2).items():
        _, faces = _elements_of(entities, 2, f"boundary {name!r}")
        found_boundaries[name] = np.searchsorted(sorted_tags, faces)
    for what, wanted_names, found in (("region", regions, found_regions), ("boundary", boundaries, found_boundaries)):
        missing = sorted(set(wanted_names) - set(found))
        if missing:
            raise ValueError(f"{what} {', '.join(missing)} lost: gmsh's model has {', '.join(sorted(found)) or 'none'}")
    used = np.unique(np.concatenate([c.ravel() for c in cells.values()]))
    new = np.full(len(points), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    result = MeshData(
        points[used],
        {name: new[c] for name, c in cells.items()},
        found_regions,
        {name: new[f] for name, f in found_boundaries.items()},
    )
    check(result)
    return result


def check(data: MeshData) -> None:
    """Raise ValueError for an empty or misnumbered region, an empty boundary, or a boundary face of no cell."""
    known = [_keys(_cell_faces(c, name).reshape(-1, _width(name)), len(data.points)) for name, c in data.cells.items()]
    for name, numbers in data.regions.items():
        if len(numbers) == 0:
            raise ValueError(f"region {name!r} is empty")
        if numbers.min() < 0 or numbers.max() >= data.count:
            raise ValueError(f"region {name!r} names cell {numbers.max()} of {data.count}")
    for name, faces in data.boundaries.items():
        if len(faces) == 0:
            raise ValueError(f"boundary {name!r} is empty")
        corners = 3 if faces.shape[1] in (3, 6) else 4
        wanted = _keys(faces[:, :corners], len(data.points))
        found = np.zeros(len(faces), dtype=bool)
        for keys in known:
            found |= np.isin(wanted, keys)
        if not found.all():
            raise ValueError(f"boundary {name!r}: {np.count_nonzero(~found)} of {len(faces)} faces belong to no cell")


def to_skfem(data: MeshData, element: str) -> Any:
    """scikit-fem mesh (MeshTet1, MeshTet2, MeshHex1 or MeshHex2) of the cells of that element, names included.

    Facets lie in `mesh.boundaries[name]`, cells in `mesh.subdomains[name]`. scikit-fem renumbers the points of
    second-order meshes: match them by coordinates. Raises ValueError if the mesh has other elements too, or if a named
    region or boundary is lost or changes its size.
    """
    import skfem

    if set(data.cells) != {element}:
        raise ValueError(
            f"the mesh has elements {', '.join(data.cells)}; scikit-fem takes one kind, asked for {element}"
        )
    kind = {"P1": skfem.MeshTet1, "P2": skfem.MeshTet2, "Q1": skfem.MeshHex1, "Q2": skfem.MeshHex2}[element]
    cells = data.cells[element]
    mesh = kind(np.ascontiguousarray(data.points.T), np.ascontiguousarray(cells[:, _SKFEM[element]].T))
    corners = np.unique(cells[:, : _CORNERS[element]])  # scikit-fem numbers the vertices of second-order meshes first
    number = np.arange(len(data.points))
    if element in ("P2", "Q2"):
        number = np.full(len(data.points), -1)
        number[corners] = np.arange(len(corners))
    count = len(data.points)
    facets = _keys(np.asarray(mesh.facets.T, dtype=np.int64), count)
    order = np.argsort(facets)
    boundaries = {}
    for name, faces in data.boundaries.items():
        wanted = _keys(number[faces[:, : _width(element)]], count)
        place = np.minimum(np.searchsorted(facets, wanted, sorter=order), len(order) - 1)
        if not np.array_equal(facets[order[place]], wanted):
            raise ValueError(f"boundary {name!r} lost on the way to scikit-fem")
        boundaries[name] = np.unique(order[place]).astype(np.int32)
    if boundaries:
        mesh = mesh.with_boundaries(boundaries)
    if data.regions:
        mesh = mesh.with_subdomains({name: cells.astype(np.int32) for name, cells in data.regions.items()})
    for name, facets_of in boundaries.items():
        if len((mesh.boundaries or {}).get(name, ())) != len(facets_of):
            raise ValueError(f"boundary {name!r} lost on the way to scikit-fem")
    for name, cells_of in data.regions.items():
        if len((mesh.subdomains or {}).get(name, ())) != len(cells_of):
            raise ValueError(f"region {name!r} lost on the way to scikit-fem")
    return mesh


def write_vtu(
    path: str | Path,
    data: MeshData,
    point_fields: Mapping[str, FloatArray] | None = None,
    cell_fields: Mapping[str, FloatArray] | None = None,
) -> None:
    """Write mesh and fields with meshio: .vtu, .msh (gmsh 2.2), .inp (Abaqus, CalculiX) or .med, by the suffix.

    point_fields: shape (n,) or (n, k); cell_fields: shape (cells,) or (cells, k), cells counted through `data.cells`.
    Regions go along as the cell field `region` (their place in `data.regions`, -1 for none). .inp and .med carry no
    27-node hexahedron: its face and centre nodes are left out of the cells (20 nodes); .inp takes no fields.
    Raises ValueError for another suffix or a field of wrong length, ImportError for .med without h5py.
    """
    import meshio

    path = Path(path)
    suffix = path.suffix.lower()
    formats = {".vtu": "vtu", ".msh": "gmsh22", ".inp": "abaqus", ".med": "med"}
    if suffix not in formats:
        raise ValueError(f"{path.name}: suffix {suffix!r}, expected one of {', '.join(formats)}")
    point_data = {name: np.asarray(v) for name, v in (point_fields or {}).items()}
    cell_data = {name: np.asarray(v) for name, v in (cell_fields or {}).items()}
    if data.regions and "region" not in cell_data:
        cell_data["region"] = np.full(data.count, -1)
        for k, cells in enumerate(data.regions.values()):
            cell_data["region"][cells] = k
    for fields, length in ((point_data, len(data.points)), (cell_data, data.count)):
        for name, values in fields.items():
            if len(values) != length:
                raise ValueError(f"field {name!r} has {len(values)} values, expected {length}")
    blocks = []
    for name, cells in data.cells.items():
        kind, order = _VTK[name]
        if name == "Q2" and suffix in (".inp", ".med"):
            kind, order = "hexahedron20", order[:20]
        blocks.append((kind, cells[:, order]))
    ends = np.cumsum([len(c) for c in data.cells.values()])[:-1]
    mesh = meshio.Mesh(data.points, blocks)
    if suffix != ".inp":
        mesh.point_data = point_data
        mesh.cell_data = {name: np.split(values, ends) for name, values in cell_data.items()}
    meshio.write(path, mesh, file_format=formats[suffix])
    if suffix == ".inp":  # meshio picks reduced and hybrid variants of the elements
        text = path.read_text()
        for theirs, plain in (("C3D8RH", "C3D8"), ("C3D20RH", "C3D20"), ("C3D10MH", "C3D10")):
            text = text.replace(f"TYPE={theirs}", f"TYPE={plain}")
        path.write_text(text)


def _groups(dimension: int) -> dict[str, list[int]]:
    """Entities of the named physical groups of that dimension."""
    import gmsh

    groups: dict[str, list[int]] = {}
    for _, tag in gmsh.model.getPhysicalGroups(dimension):
        name = gmsh.model.getPhysicalName(dimension, tag)
        if not name:
            raise ValueError(f"physical group {tag} of dimension {dimension} has no name")
        groups.setdefault(name, []).extend(int(e) for e in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag))
    return groups


def _elements_of(entities: list[int], dimension: int, what: str) -> tuple[IntArray, IntArray]:
    """Element tags and, for faces, node tags (k, nodes) of the elements on the entities."""
    import gmsh

    found: dict[int, list[IntArray]] = {}
    tags: list[IntArray] = []
    for entity in sorted(set(entities)):
        for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity), strict=True):
            found.setdefault(int(kind), []).append(np.asarray(nodes, dtype=np.int64))
            tags.append(np.asarray(elements, dtype=np.int64))
    if not tags:
        raise ValueError(f"{what} is empty: its entities carry no elements")
    if dimension == 3:
        return np.concatenate(tags), np.empty((0, 0), dtype=np.int64)
    if len(found) > 1:
        raise ValueError(f"{what} mixes faces of gmsh's types {sorted(found)}")
    kind = next(iter(found))
    widths = {2: 3, 9: 6, 3: 4, 10: 9}
    if kind not in widths:
        raise ValueError(f"{what} has faces of gmsh's type {kind}, expected one of {sorted(widths)}")
    return np.concatenate(tags), np.concatenate(found[kind]).reshape(-1, widths[kind])


def _known(types: Iterable[int], what: str) -> None:
    """Raise ValueError for volume elements other than ours."""
    strange = sorted({int(t) for t in types} - set(VOLUMES))
    if strange:
        raise ValueError(f"{what} has volume cells of gmsh's types {strange}, expected only {sorted(VOLUMES)}")


def _width(element: str) -> int:
    """Corners of a face."""
    return 3 if element in ("P1", "P2") else 4


def _cell_faces(cells: IntArray, element: str) -> IntArray:
    """Corner nodes of every face of every cell, shape (m, faces, corners)."""
    table = _TETRAHEDRON if element in ("P1", "P2") else _HEXAHEDRON
    faces: IntArray = cells[:, np.array(table)]
    return faces


def _keys(faces: IntArray, count: int) -> IntArray:
    """One number for each face, the same for any order of its corners; three corners name a face of a mesh."""
    low = np.sort(faces, axis=1)[:, :3]
    if count < 2**21:
        return (low[:, 0] * count + low[:, 1]) * count + low[:, 2]
    raise ValueError(f"{count} points: face keys hold fewer than {2**21}")
