"""Meshes out of gmsh as plain arrays, onward to scikit-fem and to files; nothing with a name is lost on the way.

Arrays come from gmsh's API, not from a file: scikit-fem 12.0.2 silently drops the named boundaries of second-order
meshes that it reads through meshio. Node order is gmsh's; it is permuted here, once, for scikit-fem and for VTK.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.deck import element_faces
from rollbench.meshes.leftovers import temporary

VOLUMES = {4: "P1", 11: "P2", 5: "Q1", 12: "Q2"}
"""Volume elements by gmsh's element type."""
_NODES = {"P1": 4, "P2": 10, "Q1": 8, "Q2": 27}

# Place k of the other program's cell holds gmsh's local node; by matching coordinates (see the tests).
VTK: dict[str, tuple[str, tuple[int, ...]]] = {
    "P1": ("tetra", tuple(range(4))),
    "P2": ("tetra10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    "Q1": ("hexahedron", tuple(range(8))),
    "Q2": ("hexahedron27", (*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26)),
}

# Place k of MED's cell holds meshio's (VTK's) local node: the first face turned round (checked by reading with gmsh).
_MED: dict[str, tuple[int, ...]] = {
    "tetra": (0, 2, 1, 3),
    "tetra10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8),
    "hexahedron": (0, 3, 2, 1, 4, 7, 6, 5),
    "hexahedron20": (0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17),
}
_ABAQUS = {"tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20"}
_FACES = {3: "triangle", 6: "triangle6", 4: "quad", 9: "quad9"}
_CORNERS = {3: 3, 6: 3, 4: 4, 9: 4}
_MESHIO = {"vtu": "vtu", "msh": "gmsh", "med": "med"}

FORMATS = {"vtu": "VTK files", "msh": "gmsh files", "med": "MED files", "inp": "Abaqus files"}
"""Formats of mesh files by their suffix, without the dot."""


@dataclass(frozen=True, eq=False)
class MeshData:
    """A volume mesh.

    points: shape (n, 3) [m]; cells: node indices (m, nodes) by element name (P1, P2, Q1, Q2), gmsh's node order;
    regions: cell numbers by name, counted through `cells` in its order; boundaries: faces (k, nodes of a face) by name.
    """

    points: Array
    cells: dict[str, Index]
    regions: dict[str, Index] = field(default_factory=dict)
    boundaries: dict[str, Index] = field(default_factory=dict)

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
    cells: dict[str, Index] = {}
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
    for group, wanted_names, present in (("region", regions, found_regions), ("boundary", boundaries, found_boundaries)):
        missing = sorted(set(wanted_names) - set(present))
        if missing:
            raise ValueError(f"{group} {', '.join(missing)} lost: gmsh's model has {', '.join(sorted(present)) or 'none'}")
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
    """Raise ValueError for cells of several kinds, a region that is empty or misnumbered, a boundary that is lost."""
    for name, numbers in data.regions.items():
        if len(numbers) == 0:
            raise ValueError(f"region {name!r} is empty")
        if numbers.min() < 0 or numbers.max() >= data.count:
            raise ValueError(f"region {name!r} names cell {numbers.max()} of {data.count}")
    to_skfem(data, *data.cells)


def to_skfem(data: MeshData, *elements: str) -> Any:
    """scikit-fem mesh (MeshTet1, MeshTet2, MeshHex1 or MeshHex2) of cells of one element, names included.

    Facets lie in `mesh.boundaries[name]`, cells in `mesh.subdomains[name]`. scikit-fem renumbers the points of
    second-order meshes. Raises ValueError if the mesh has other elements too, or if a boundary is lost.
    """
    from rollbench.meshes.fem import mesh_of

    if len(elements) != 1 or set(data.cells) != set(elements):
        kinds, wanted = ", ".join(data.cells), ", ".join(elements)
        raise ValueError(f"the mesh has elements {kinds}; scikit-fem takes one kind, asked for {wanted}")
    return mesh_of(data.points, data.cells[elements[0]], elements[0], data.boundaries, data.regions)[0]


def from_skfem(mesh: Any, *boundaries: str) -> MeshData:
    """A scikit-fem mesh of the parts in gmsh's node order, with its subdomains and the named ones of its boundaries."""
    from rollbench.meshes.fem import cells_of, faces_of, kind_of, points_of

    regions = {name: np.asarray(cells, dtype=np.int64) for name, cells in (mesh.subdomains or {}).items()}
    faces = {name: faces_of(mesh, name) for name in boundaries}
    return MeshData(points_of(mesh), {kind_of(mesh): cells_of(mesh)}, regions, faces)


def form_of(path: Path, form: str = "") -> str:
    """Format of a mesh file: `form` if given, else by the suffix; raises ValueError for one that is not in `FORMATS`."""
    found = form or path.suffix.lower().removeprefix(".")
    if found in FORMATS:
        return found
    wanted = ", ".join(f".{name}" for name in FORMATS)
    raise ValueError(f"{path.name}: {f'format {form!r}' if form else f'suffix {path.suffix!r}'}, expected one of {wanted}")


def need(form: str) -> None:
    """Raise ImportError, with what to do, if a package that writes the format is missing."""
    for package in ("meshio", *(("h5py",) if form == "med" else ())):
        try:
            import_module(package)
        except ImportError as error:
            raise ImportError(f"{FORMATS[form]} need {package}, which cannot be loaded: pip install {package}") from error


def reduced(data: MeshData, form: str) -> bool:
    """Whether the format holds only part of the mesh: .inp and .med have no 27-node hexahedron."""
    return "Q2" in data.cells and form in ("inp", "med")


def write_mesh(
    path: str | Path,
    data: MeshData,
    point_fields: Mapping[str, Array] | None = None,
    cell_fields: Mapping[str, Array] | None = None,
    form: str = "",
) -> None:
    """Write mesh and fields, whole or not at all: .vtu, .msh (gmsh 4.1), .inp (Abaqus, CalculiX) or .med (Salome).

    point_fields: shape (n,) or (n, k); cell_fields: shape (cells,) or (cells, k), cells counted through `data.cells`;
    form: one of `FORMATS`, by the suffix unless given. Names go along: regions as groups of cells, in .vtu as the cell
    field `region` (their place in `data.regions`, -1 for none); boundaries as faces with a physical group in .msh, as
    groups of nodes in .inp and .med, as surfaces in .inp, as point fields `boundary <name>` of 0 and 1 in .vtu; in .vtu and
    .msh also as the cell fields by which `skfem.Mesh.load` knows them. Where a format is `reduced`, the face and centre
    nodes of 27-node hexahedra are left out (20 nodes); .inp takes no fields.
    Raises ValueError for an unknown format, a field of wrong length or that the format cannot hold, a cell in two regions,
    ImportError where a package is missing, OSError where the file cannot be written.
    """
    path = Path(path)
    form = form_of(path, form)
    need(form)
    point_data = {name: np.asarray(v) for name, v in (point_fields or {}).items()}
    cell_data: dict[str, Any] = {name: np.asarray(v) for name, v in (cell_fields or {}).items()}
    for fields, length in ((point_data, len(data.points)), (cell_data, data.count)):
        for name, values in fields.items():
            if len(values) != length:
                raise ValueError(f"field {name!r} has {len(values)} values, expected {length}")
    region = np.full(data.count, -1)
    for k, cells in enumerate(data.regions.values()):
        if np.any(region[cells] >= 0):
            raise ValueError(f"region {list(data.regions)[k]!r} shares cells with another: a file holds one for each cell")
        region[cells] = k
    nodes = {name: np.unique(faces) for name, faces in data.boundaries.items()}
    corners = {name: faces[:, : _CORNERS[faces.shape[1]]] for name, faces in data.boundaries.items()}
    points, blocks = data.points, [(*VTK[name], cells) for name, cells in data.cells.items()]
    if reduced(data, form):
        blocks = [("hexahedron20", o[:20], c) if kind == "hexahedron27" else (kind, o, c) for kind, o, c in blocks]
    connected = [(kind, cells[:, order]) for kind, order, cells in blocks]
    if reduced(data, form):
        used, numbers = np.unique(np.concatenate([c.ravel() for _, c in connected]), return_inverse=True)
        ends = np.cumsum([c.size for _, c in connected])[:-1]
        connected = [(k, n.reshape(c.shape)) for (k, c), n in zip(connected, np.split(numbers, ends), strict=True)]
        points = points[used]
        point_data = {name: values[used] for name, values in point_data.items()}
        nodes = {name: np.flatnonzero(np.isin(used, members)) for name, members in nodes.items()}
        corners = {name: np.searchsorted(used, members) for name, members in corners.items()}
    if form in ("vtu", "msh"):
        cell_data.update(_skfem_fields(data))
    plain = _Plain(points, connected, point_data, cell_data, region, tuple(data.regions), nodes, corners)
    fresh = temporary(path, f"{form}.tmp")
    try:
        if form == "inp":
            _write_inp(fresh, plain)
        else:
            import meshio

            mesh = _as_vtu(plain) if form == "vtu" else _as_med(plain) if form == "med" else _as_msh(plain, data.boundaries)
            meshio.write(fresh, mesh, file_format=_MESHIO[form])
        os.replace(fresh, path)
    finally:
        fresh.unlink(missing_ok=True)


@dataclass(frozen=True, eq=False)
class _Plain:
    """Data of all formats: points, cells in VTK's node order by meshio's names, fields, place of every cell's
    region (-1 for none), names of the regions, nodes of the boundaries, corners of their faces."""

    points: Array
    blocks: list[tuple[str, Index]]
    point_data: dict[str, Any]
    cell_data: dict[str, Any]
    region: Index
    regions: tuple[str, ...]
    nodes: dict[str, Index]
    corners: dict[str, Index]

    def split(self, values: Any) -> list[Any]:
        """Cell values by blocks."""
        return np.split(values, np.cumsum([len(c) for _, c in self.blocks])[:-1])


def _skfem_fields(data: MeshData) -> dict[str, Index]:
    """Cell fields in which scikit-fem keeps names: which faces of a cell are of a boundary, as bits; cells of a region.

    They are its own (`Mesh.save`): it reads no names of second-order meshes from a file's groups. None for cells that are
    not of one kind and region, which it does not read so.
    """
    if len(data.cells) != 1 or len(data.regions) > 1:
        return {}
    fields = {}
    mesh = to_skfem(data, *data.cells)
    bits = 1 << np.arange(len(mesh.t2f))
    for name, faces in (mesh.boundaries or {}).items():  # hexahedra are read the other way round: corner 7 - k, face 5 - k
        fields[f"skfem:b:{name}"] = (bits[::-1] if len(bits) == 6 else bits) @ np.isin(mesh.t2f, faces)
    for name, members in data.regions.items():
        fields[f"skfem:s:{name}"] = np.isin(np.arange(data.count), members).astype(np.int64)
    return fields


def _as_vtu(plain: _Plain) -> Any:
    import meshio

    points = dict(plain.point_data)
    for name, members in plain.nodes.items():
        points[f"boundary {name}"] = np.isin(np.arange(len(plain.points)), members).astype(np.uint8)
    cells = dict(plain.cell_data)
    if plain.regions:
        cells.setdefault("region", plain.region)
    return meshio.Mesh(plain.points, plain.blocks, points, {name: plain.split(v) for name, v in cells.items()})


def _as_msh(plain: _Plain, faces: Mapping[str, Index]) -> Any:
    """Regions (cells of none: "other") and boundaries as entities with a physical group; cell fields are not a number on
    the boundaries' faces.

    Cells come region by region. In this format an entity is known by a node that lies on it, so that each needs one.
    """
    import meshio

    for name, values in (*plain.point_data.items(), *plain.cell_data.items()):
        if values.size not in (len(values), 3 * len(values), 9 * len(values)):
            raise ValueError(f"field {name!r} has {values.size // len(values)} components: an .msh file takes 1, 3 or 9")
    blocks, groups, entities = [], list[Index](), list[tuple[int, int]]()
    fields: dict[str, list[Any]] = {name: [] for name in plain.cell_data}
    regions = (*plain.regions, *(["other"] if np.any(plain.region < 0) else []))
    region_of = np.where(plain.region < 0, len(plain.regions), plain.region)
    parted = [plain.split(values) for values in (region_of, *plain.cell_data.values())]
    for (kind, cells), region, *data in zip(plain.blocks, *parted, strict=True):
        for index in np.unique(region):
            inside = region == index
            blocks.append((kind, cells[inside]))
            groups.append(np.full(inside.sum(), len(faces) + index + 1))
            entities.append((3, len(blocks)))
            for values, of_block in zip(fields.values(), data, strict=True):
                values.append(np.asarray(of_block[inside], dtype=float))
    for number, corners in enumerate(faces.values(), start=1):
        blocks.append((_FACES[corners.shape[1]], corners))
        groups.append(np.full(len(corners), number))
        entities.append((2, number))
        for values in fields.values():
            values.append(np.full((len(corners), *values[0].shape[1:]), np.nan))
    field_data = {name: np.array([k, 2]) for k, name in enumerate(faces, start=1)}
    field_data |= {name: np.array([k, 3]) for k, name in enumerate(regions, start=len(faces) + 1)}
    tags = [np.full(len(group), tag) for group, (_, tag) in zip(groups, entities, strict=True)]
    owners = _owners([nodes for _, nodes in blocks], len(plain.points))
    points = {**plain.point_data, "gmsh:dim_tags": np.array(entities)[owners]}
    return meshio.Mesh(
        plain.points, blocks, points, {**fields, "gmsh:physical": groups, "gmsh:geometrical": tags}, field_data
    )


def _owners(cells: list[Index], count: int) -> Index:
    """One of the sets of ``cells`` for every node ``(count,)``, the smallest that has it, so that each set has a node."""
    nodes = [np.unique(members) for members in cells]
    owner = np.zeros(count, dtype=np.int64)
    for k in sorted(range(len(nodes)), key=lambda k: -nodes[k].size):
        owner[nodes[k]] = k
    for k, members in enumerate(nodes):
        shared = np.bincount(owner, minlength=len(nodes)) > 1
        if not np.any(owner[members] == k):
            owner[members[shared[owner[members]]][0]] = k
    return owner


def _as_med(plain: _Plain) -> Any:
    """Regions and boundaries as families; meshio writes cells as they are, but MED orients them the other way."""
    import meshio

    blocks = [(kind, cells[:, _MED[kind]]) for kind, cells in plain.blocks]
    points = {name: np.asarray(values, dtype=float) for name, values in plain.point_data.items()}
    cells = {name: plain.split(np.asarray(values, dtype=float)) for name, values in plain.cell_data.items()}
    components = [[f"C{k + 1}" for k in range(int(np.prod(v.shape[1:])))] for v in points.values()]
    components += [[f"C{k + 1}" for k in range(int(np.prod(v[0].shape[1:])))] for v in cells.values()]
    node_families: dict[int, list[str]] = {}
    if plain.nodes:
        names = np.array(list(plain.nodes))
        belongs = np.stack([np.isin(np.arange(len(plain.points)), members) for members in plain.nodes.values()])
        patterns, pattern_of = np.unique(belongs, axis=1, return_inverse=True)
        families = np.where(patterns.any(axis=0), 1 + np.arange(patterns.shape[1]), 0)  # 0: in no group
        points["point_tags"] = families[pattern_of.ravel()]
        node_families = {int(n): list(map(str, names[p])) for n, p in zip(families, patterns.T, strict=True) if n}
    if plain.regions:
        cells["cell_tags"] = plain.split(-1 - plain.region)
    mesh = meshio.Mesh(plain.points, blocks, points, cells, {"med:nom": components} if components else {})
    mesh.point_tags = node_families
    mesh.cell_tags = {-1 - k: [name] for k, name in enumerate(plain.regions)}
    return mesh


def _write_inp(path: Path, plain: _Plain) -> None:
    """Abaqus' input; not by meshio, whose lines are longer than the 16 entries allowed and whose elements are hybrid.

    CalculiX reads numbers of at most 20 characters: thirteen digits are 1e-12 of the mesh's size.
    """
    if plain.point_data or plain.cell_data:
        raise ValueError("an .inp file takes no fields: write a .vtu, .msh or .med file")
    with path.open("w", encoding="ascii") as file:
        file.write("*HEADING\nrollbench; lengths in m\n*NODE, NSET=NALL\n")
        for k, (x, y, z) in enumerate(plain.points.tolist(), start=1):
            file.write(f"{k}, {x:.12e}, {y:.12e}, {z:.12e}\n")
        number = 0
        for kind, cells in plain.blocks:
            file.write(f"*ELEMENT, ELSET=EALL, TYPE={_ABAQUS[kind]}\n")
            for row in (cells + 1).tolist():
                number += 1
                file.write(_lines([number, *row]))
        sets = [("NSET", name, members) for name, members in plain.nodes.items()]
        sets += [("ELSET", name, np.flatnonzero(plain.region == k)) for k, name in enumerate(plain.regions)]
        for keyword, name, members in sets:
            file.write(f"*{keyword}, {keyword}={name.replace(' ', '_')}\n{_lines((members + 1).tolist(), open_end=False)}")
        for name, corners in plain.corners.items():
            file.write(f"*SURFACE, NAME={name.replace(' ', '_')}, TYPE=ELEMENT\n")
            file.writelines(f"{cell + 1}, S{face}\n" for cell, face in element_faces(plain.blocks[0][1], corners).tolist())


def _lines(entries: list[int], *, open_end: bool = True) -> str:
    """Entries, at most 16 on a line; lines that the next one continues end with a comma (`open_end`), or do not."""
    rows = [", ".join(map(str, entries[k : k + 16])) for k in range(0, len(entries), 16)]
    return (",\n" if open_end else "\n").join(rows) + "\n"


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


def _elements_of(entities: list[int], dimension: int, subject: str) -> tuple[Index, Index]:
    """Element tags and, for faces, node tags (k, nodes) of the elements on the entities."""
    import gmsh

    by_kind: dict[int, list[Index]] = {}
    tags: list[Index] = []
    for entity in sorted(set(entities)):
        for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity), strict=True):
            by_kind.setdefault(int(kind), []).append(np.asarray(nodes, dtype=np.int64))
            tags.append(np.asarray(elements, dtype=np.int64))
    if not tags:
        raise ValueError(f"{subject} is empty: its entities carry no elements")
    if dimension == 3:
        return np.concatenate(tags), np.empty((0, 0), dtype=np.int64)
    if len(by_kind) > 1:
        raise ValueError(f"{subject} mixes faces of gmsh's types {sorted(by_kind)}")
    kind = next(iter(by_kind))
    widths = {2: 3, 9: 6, 3: 4, 10: 9}
    if kind not in widths:
        raise ValueError(f"{subject} has faces of gmsh's type {kind}, expected one of {sorted(widths)}")
    return np.concatenate(tags), np.concatenate(by_kind[kind]).reshape(-1, widths[kind])


def _known(types: Iterable[int], subject: str) -> None:
    """Raise ValueError for volume elements of another type than the package makes."""
    strange = sorted({int(t) for t in types} - set(VOLUMES))
    if strange:
        raise ValueError(f"{subject} has volume cells of gmsh's types {strange}, expected only {sorted(VOLUMES)}")
