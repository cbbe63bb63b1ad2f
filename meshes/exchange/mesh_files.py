"""Write FE meshes to files for other programs (VTK, gmsh, MED, Abaqus), with names of regions and boundaries."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from copy import copy
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.exchange.deck import mesh_lines
from rollbench.meshes.files import temporary_path
from rollbench.meshes.libraries import pip_command

if TYPE_CHECKING:
    from skfem import Mesh

#: For each element type, its name in meshio, and the number in gmsh's cell of each node of VTK's cell (checked by tests).
VTK: dict[str, tuple[str, tuple[int, ...]]] = {
    "P1": ("tetra", tuple(range(4))),
    "P2": ("tetra10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    "Q1": ("hexahedron", tuple(range(8))),
    "Q2": ("hexahedron27", (*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26)),
}
# Number, in meshio's (VTK's) cell, of each node of MED's cell: MED orients the first face in reverse (checked with gmsh).
_MED: dict[str, tuple[int, ...]] = {
    "tetra": (0, 2, 1, 3),
    "tetra10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8),
    "hexahedron": (0, 3, 2, 1, 4, 7, 6, 5),
    "hexahedron20": (0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17),
}
#: For each element type by its name in meshio, its name in Abaqus.
_ABAQUS = {"tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20"}
#: For each number of nodes of a face, the name of its element type in meshio.
_FACES = {3: "triangle", 6: "triangle6", 4: "quad", 8: "quad8", 9: "quad9"}
#: For each format of mesh files that meshio writes, its name in meshio.
_MESHIO = {"vtu": "vtu", "msh": "gmsh", "med": "med"}

FORMATS = {"vtu": "VTK files", "msh": "gmsh files", "med": "MED files", "inp": "Abaqus files"}
"""Names of the formats of mesh files, by the file's suffix without the dot."""


def mesh_format(path: Path, given_format: str = "") -> str:
    """Return the format of a mesh file, such as "vtu": the given one, or that of the file's suffix.

    Parameters
    ----------
    path : Path
        Mesh file.
    given_format : str, default ''
        Name of the format; where empty, the suffix of the file decides.

    Returns
    -------
    str
        Name of the format, a key of `FORMATS`.

    Raises
    ------
    ValueError
        The format is unknown.

    Examples
    --------
    >>> mesh_format(Path("screw.VTU"))
    'vtu'
    """
    found = given_format or path.suffix.lower().removeprefix(".")
    if found in FORMATS:
        return found
    wanted = ", ".join(f".{name}" for name in FORMATS)
    what = f"format {given_format!r}" if given_format else f"suffix {path.suffix!r}"
    raise ValueError(f"{path.name}: a mesh file of unknown {what}, expected one of {wanted}")


def check_packages_for_format(file_format: str) -> None:
    """Raise ImportError if a package that writes a mesh format is missing; the message says how to install it.

    Parameters
    ----------
    file_format : str
        Format, a key of `FORMATS`.
    """
    for package in ("meshio", *(("h5py",) if file_format == "med" else ())):
        try:
            import_module(package)
        except ImportError as error:
            raise ImportError(
                f"{FORMATS[file_format]} need {package}, which cannot be loaded: {pip_command(package)}"
            ) from error


def loses_nodes_in_format(mesh: Mesh, file_format: str) -> bool:
    """Return whether a file format cannot store all nodes of a mesh: .inp and .med have no 27-node hexahedron.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    file_format : str
        Format, a key of `FORMATS`.

    Returns
    -------
    bool
        True for 27-node hexahedra in .inp and .med.
    """
    from rollbench.meshes.fem import element_type_of_mesh

    return element_type_of_mesh(mesh) == "Q2" and file_format in ("inp", "med")


def with_only_boundaries(mesh: Mesh, *names: str) -> Mesh:
    """Return a copy of a mesh with only some of its named boundaries.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    *names : str
        Names of the boundaries of the copy.

    Returns
    -------
    Mesh
        Copy of the mesh with only these boundaries.
    """
    chosen = copy(mesh)
    chosen.__dict__["_boundaries"] = {name: mesh.boundaries[name] for name in names}
    return chosen


def write_mesh(
    path: str | Path, mesh: Mesh, fields: Mapping[str, Array] | None = None, *, region: str = "", file_format: str = ""
) -> None:
    """Write a mesh and fields at its nodes to a file: .vtu, .msh (gmsh 4.1), .inp (Abaqus, CalculiX) or .med (Salome).

    The file is replaced only when it is complete. Names are written too. The region is a group of cells; in .vtu it is a
    cell field ``region`` of zeros. A boundary is a physical group of faces in .msh; groups of faces and of nodes in .med; a
    surface and a set of nodes in .inp; a point field ``boundary <name>`` of 0 and 1 in .vtu. In .vtu and .msh, names are
    also written as the cell fields that `skfem.Mesh.load` reads. For formats without 27-node hexahedra
    (`loses_nodes_in_format`), the nodes at the centres of faces and cells are omitted, so that 20 nodes remain.

    Parameters
    ----------
    path : str | Path
        File to write.
    mesh : Mesh
        The mesh.
    fields : dict of (n,) or (n, k) Array, optional, default None
        Fields at the n nodes, by their names; not possible in .inp.
    region : str, default ''
        Name of the group of all cells; where empty, no group is written.
    file_format : str, default ''
        Format, a key of `FORMATS`; where empty, the suffix of the file decides.

    Raises
    ------
    ValueError
        The format is unknown, or a field has a wrong length or cannot be written in the format.
    ImportError
        A package that writes the format is missing.
    OSError
        The file cannot be written.
    """
    from rollbench.meshes.fem import element_type_of_mesh, node_coordinates, nodes_of_boundary_faces, nodes_of_cells

    path = Path(path)
    file_format = mesh_format(path, file_format)
    check_packages_for_format(file_format)
    fields = {name: np.asarray(v) for name, v in (fields or {}).items()}
    points = node_coordinates(mesh)
    for name, values in fields.items():
        if len(values) != len(points):
            raise ValueError(f"field {name!r} has {len(values)} values, expected {len(points)}, one for each node")
    cell, order = VTK[element_type_of_mesh(mesh)]
    cells = nodes_of_cells(mesh)[:, order]
    faces = {name: nodes_of_boundary_faces(mesh, name) for name in mesh.boundaries or {}}
    marks = _fields_naming_boundaries(mesh, region) if file_format in ("vtu", "msh") else {}
    if loses_nodes_in_format(mesh, file_format):
        cell = "hexahedron20"
        used, cells = np.unique(cells[:, :20], return_inverse=True)
        points, cells = points[used], cells.reshape(-1, 20)
        fields = {name: values[used] for name, values in fields.items()}
        faces = {name: np.searchsorted(used, members[:, :8]) for name, members in faces.items()}
    fresh = temporary_path(path, f"{file_format}.tmp")
    try:
        if file_format == "inp":
            if fields:
                raise ValueError("an .inp file cannot contain fields: write a .vtu, .msh or .med file")
            _write_abaqus_input(fresh, points, cell, cells, faces, region)
        else:
            import meshio

            plain = meshio.Mesh(points, [(cell, cells)], fields)
            converters = {"vtu": _meshio_mesh_for_vtu, "msh": _meshio_mesh_for_msh, "med": _meshio_mesh_for_med}
            meshed = converters[file_format](plain, faces, region, marks)
            meshio.write(fresh, meshed, file_format=_MESHIO[file_format])
        os.replace(fresh, path)
    finally:
        fresh.unlink(missing_ok=True)


def _fields_naming_boundaries(mesh: Mesh, region: str) -> dict[str, Index]:
    """Return the cell fields in which scikit-fem stores names of boundaries and regions, as `Mesh.save` writes them.

    The field of a boundary holds an integer for each cell: bit k is set where face k of the cell lies on the boundary.
    These fields are needed because scikit-fem does not read names of second-order meshes from a file's groups.
    """
    bits = 1 << np.arange(len(mesh.t2f))
    if len(bits) == 6:  # hexahedra are read in reverse order: corner 7 - k, face 5 - k
        bits = bits[::-1]
    fields = {f"skfem:b:{name}": bits @ np.isin(mesh.t2f, faces) for name, faces in (mesh.boundaries or {}).items()}
    return fields | ({f"skfem:s:{region}": np.ones(mesh.nelements, dtype=np.int64)} if region else {})


def _meshio_mesh_for_vtu(plain: Any, faces: Mapping[str, Index], region: str, marks: Mapping[str, Index]) -> Any:
    """Return a mesh of meshio for a .vtu file, after adding fields that mark its boundaries and region.

    ``plain``: mesh of meshio, which is changed; ``faces``: nodes of each boundary's faces ``(k, nodes)``, by its name;
    ``region``: name of the group of all cells, or empty; ``marks``: cell fields from `_fields_naming_boundaries`.
    """
    for name, members in faces.items():
        plain.point_data[f"boundary {name}"] = np.isin(np.arange(len(plain.points)), members).astype(np.uint8)
    count = len(plain.cells[0].data)
    cell_data = {**marks, **({"region": np.zeros(count, dtype=np.int64)} if region else {})}
    plain.cell_data = {name: [values] for name, values in cell_data.items()}
    return plain


def _meshio_mesh_for_msh(plain: Any, faces: Mapping[str, Index], region: str, marks: Mapping[str, Index]) -> Any:
    """Return a mesh of meshio for a .msh file, with physical groups for the region and the boundaries.

    A region without a name is called "other". In this format each region and each boundary must have a node that belongs to
    it alone. Cell fields are NaN on the faces of boundaries. Arguments as for `_meshio_mesh_for_vtu`; ``plain`` is not
    changed.
    """
    import meshio

    for name, values in plain.point_data.items():
        if values.size not in (len(values), 3 * len(values), 9 * len(values)):
            raise ValueError(f"field {name!r} has {values.size // len(values)} components: a .msh file allows 1, 3 or 9")
    (cells,) = plain.cells
    blocks = [(cells.type, cells.data), *((_FACES[members.shape[1]], members) for members in faces.values())]
    entities = [(3, 1), *((2, number) for number in range(1, len(blocks)))]
    groups = [len(blocks), *range(1, len(blocks))]
    sizes = [len(members) for _, members in blocks]
    fields = {
        name: [values.astype(float), *(np.full(size, np.nan) for size in sizes[1:])] for name, values in marks.items()
    }
    fields["gmsh:physical"] = [np.full(*x) for x in zip(sizes, groups, strict=True)]
    fields["gmsh:geometrical"] = [np.full(size, tag) for size, (_, tag) in zip(sizes, entities, strict=True)]
    names = zip((region or "other", *faces), groups, entities, strict=True)
    owners = _assign_nodes_to_sets([members for _, members in blocks], len(plain.points))
    points = {**plain.point_data, "gmsh:dim_tags": np.array(entities)[owners]}
    field_data = {name: np.array([group, dimension]) for name, group, (dimension, _) in names}
    return meshio.Mesh(plain.points, blocks, points, fields, field_data)


def _assign_nodes_to_sets(cells: list[Index], count: int) -> Index:
    """Assign each node to one of the cell sets that contain it, so that each set has at least one node of its own.

    ``cells``: for each set, the nodes of its cells ``(k, nodes)``; ``count``: number of nodes. Returns the number of the
    set to which each node is assigned ``(count,)``: the smallest set that contains it, unless a larger set would get no
    node.
    """
    nodes = [np.unique(members) for members in cells]
    owner = np.zeros(count, dtype=np.int64)
    for k in sorted(range(len(nodes)), key=lambda k: -nodes[k].size):
        owner[nodes[k]] = k
    for k, members in enumerate(nodes):
        shared = np.bincount(owner, minlength=len(nodes)) > 1
        if not np.any(owner[members] == k):
            owner[members[shared[owner[members]]][0]] = k
    return owner


def _meshio_mesh_for_med(plain: Any, faces: Mapping[str, Index], region: str, _: object) -> Any:
    """Return a mesh of meshio for a .med file, with families (groups) of cells, of boundary faces and of their nodes.

    Faces are counter-clockwise seen from outside. Nodes of cells are reordered here, because MED orients cells in reverse,
    and meshio does not change their order. Arguments as for `_meshio_mesh_for_vtu`; the last one is not used.
    """
    import meshio

    (cells,) = plain.cells
    points = {name: np.asarray(values, dtype=float) for name, values in plain.point_data.items()}
    components = [[f"C{k + 1}" for k in range(int(np.prod(values.shape[1:])))] for values in points.values()]
    blocks, tags = [(cells.type, cells.data[:, _MED[cells.type]])], [np.full(len(cells.data), -1 if region else 0)]
    node_families: dict[int, list[str]] = {}
    cell_families = {-1: [region]} if region else {}
    if faces:
        belongs = np.stack([np.isin(np.arange(len(plain.points)), members) for members in faces.values()])
        points["point_tags"], node_families = _assign_families(belongs, list(faces))
        every = np.concatenate(list(faces.values()))
        _, first, place = np.unique(np.sort(every, axis=1), axis=0, return_index=True, return_inverse=True)
        belongs = np.zeros((len(faces), len(first)), dtype=bool)
        belongs[np.repeat(np.arange(len(faces)), list(map(len, faces.values()))), place.ravel()] = True
        numbers, families = _assign_families(belongs, list(faces))
        blocks.append((_FACES[every.shape[1]], every[first]))
        tags.append(-1 - numbers)
        cell_families |= {-1 - number: names for number, names in families.items()}
    cell_data = {"cell_tags": tags} if cell_families else {}
    mesh = meshio.Mesh(plain.points, blocks, points, cell_data, {"med:nom": components} if components else {})
    mesh.point_tags, mesh.cell_tags = node_families, cell_families
    return mesh


def _assign_families(belongs: NDArray[np.bool_], names: Sequence[str]) -> tuple[Index, dict[int, list[str]]]:
    """Assign nodes or faces to families of a .med file; those that belong to the same groups form one family.

    Parameters
    ----------
    belongs : (groups, n) Mask
        Whether each of n nodes or faces belongs to each group.
    names : Sequence[str]
        Names of the groups.

    Returns
    -------
    number : (n,) Index
        Number of the family of each node or face, from 1; 0 where it belongs to no group.
    groups : dict
        Names of the groups to which each family belongs, by the number of the family.
    """
    patterns, pattern_of = np.unique(belongs, axis=1, return_inverse=True)
    numbers = np.where(patterns.any(axis=0), 1 + np.arange(patterns.shape[1]), 0)
    groups = {}
    for number, pattern in zip(numbers.tolist(), patterns.T, strict=True):
        if number:
            groups[number] = [name for name, inside in zip(names, pattern, strict=True) if inside]
    return numbers[pattern_of.ravel()], groups


def _write_abaqus_input(
    path: Path, points: Array, cell: str, cells: Index, faces: Mapping[str, Index], region: str
) -> None:
    """Write a mesh as an Abaqus input file, with sets of nodes and cells and with surfaces.

    ``points``: coordinates of the nodes ``(n, 3)`` [m]; ``cell``: element type by its name in meshio; ``cells``: nodes
    of the cells; ``faces``: nodes of each boundary's faces, by its name; ``region``: name of the group of all cells, or
    empty. meshio is not used, because its lines have more than the allowed 16 entries, and its elements are hybrid
    ones. Numbers have at most the 20 characters that CalculiX reads, so that coordinates are rounded by about 1e-12 of
    the mesh's size.
    """
    named = {name.replace(" ", "_"): members for name, members in faces.items()}
    sets = [("NSET", name, np.unique(members)) for name, members in named.items()]
    sets += [("ELSET", region.replace(" ", "_"), np.arange(len(cells)))] if region else []
    corners = 3 if cell.startswith("tetra") else 4
    surfaces = {name: members[:, :corners] for name, members in named.items()}
    headers = "*NODE, NSET=NALL", f"*ELEMENT, ELSET=EALL, TYPE={_ABAQUS[cell]}"
    text = ["*HEADING", "rollbench; lengths in m", *mesh_lines(headers, points, cells, sets, surfaces)]
    path.write_text("\n".join(text) + "\n", encoding="ascii")
