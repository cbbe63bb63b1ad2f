"""Mesh files for other programs: places, order, groups and fields survive, files appear whole or not at all."""

import os
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
import skfem
from tests.fe_meshes import boundary_faces, cube

from rollbench.meshes import bridge
from rollbench.meshes.bridge import FORMATS, MeshData, form_of, from_skfem, reduced, write_mesh
from rollbench.meshes.fem import mesh_of

VOLUMES = ["P1", "P2", "Q1", "Q2"]
GMSH_TYPES = {"P1": 4, "P2": 11, "Q1": 5, "Q2": 12}
EDGES = {
    10: [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    20: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
}
EDGES[27] = EDGES[20]
FACES_27 = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]


def example(name: str) -> MeshData:
    """A cube of two regions with two named sides that share an edge; its cells of second order are straight."""
    points, cells = cube(name, 2)
    faces = boundary_faces(cells, name)
    sides = {
        "low end": faces[np.all(points[faces][:, :, 2] < 1e-12, axis=1)],
        "side": faces[np.all(points[faces][:, :, 0] > 1.0 - 1e-12, axis=1)],
    }
    regions = {"a": np.arange(3), "b": np.arange(3, len(cells))}
    return MeshData(points + np.array([0.1, 0.2, 0.3]), {name: cells}, regions, sides)


def ordered(points: np.ndarray, cells: np.ndarray, turned: bool = False) -> None:
    """Assert that cells are ordered as Abaqus' and VTK's manuals draw them; turned: seen in a mirror, as MED's."""
    x = points[cells]
    third = 2 if cells.shape[1] in (4, 10) else 3
    fourth = 3 if cells.shape[1] in (4, 10) else 4
    det = np.linalg.det(x[:, [1, third, fourth]] - x[:, :1])
    assert np.all(-det > 0.0) if turned else np.all(det > 0.0)
    corners = 4 if third == 2 else 8
    if corners == 8:  # a parallelepiped: 2 is beyond 0 on the first face, 5, 6, 7 are above 1, 2, 3
        np.testing.assert_allclose(x[:, 2], x[:, 1] + x[:, 3] - x[:, 0], atol=1e-12)
        np.testing.assert_allclose(x[:, 5:8] - x[:, 1:4], x[:, 4:5] - x[:, :1] + np.zeros((1, 3, 1)), atol=1e-12)
    for k, edge in enumerate(EDGES.get(cells.shape[1], [])):
        np.testing.assert_allclose(x[:, corners + k], x[:, edge].mean(axis=1), atol=1e-12)
    if cells.shape[1] == 27:
        for k, face in enumerate(FACES_27):
            np.testing.assert_allclose(x[:, 20 + k], x[:, face].mean(axis=1), atol=1e-12)
        np.testing.assert_allclose(x[:, 26], x[:, :8].mean(axis=1), atol=1e-12)


def volume_cells(mesh: meshio.Mesh) -> meshio.CellBlock:
    blocks = [b for b in mesh.cells if b.dim == 3]  # one for each region in .msh
    assert len({b.type for b in blocks}) == 1
    return meshio.CellBlock(blocks[0].type, np.concatenate([b.data for b in blocks]))


@pytest.mark.parametrize("name", VOLUMES)
@pytest.mark.parametrize("form", FORMATS)
def test_cells_are_where_they_were(form, name, tmp_path: Path):
    data = example(name)
    path = tmp_path / f"cube.{form}"
    write_mesh(path, data)
    again = meshio.read(path)
    block = volume_cells(again)
    ordered(again.points, block.data, turned=form == "med")
    nodes = 20 if reduced(data, form) else data.cells[name].shape[1]
    assert block.data.shape == (len(data.cells[name]), nodes)
    ours = data.points[data.cells[name][:, :8]] if name[0] == "Q" else data.points[data.cells[name][:, :4]]
    theirs = again.points[block.data[:, : ours.shape[1]]]
    np.testing.assert_allclose(theirs.mean(axis=1), ours.mean(axis=1), atol=1e-12)
    used = np.unique(np.concatenate([b.data.ravel() for b in again.cells]))
    np.testing.assert_array_equal(used, range(len(again.points)))


@pytest.mark.parametrize("name", VOLUMES)
@pytest.mark.parametrize("form", ["msh", "med"])
def test_gmsh_reads_cells_groups_and_fields(form, name, tmp_path: Path):
    import gmsh

    data = example(name)
    cells = data.cells[name]
    count = 20 if reduced(data, form) else cells.shape[1]
    write_mesh(tmp_path / f"c.{form}", data, {"u": data.points}, {"n": np.arange(len(cells))})
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(str(tmp_path / f"c.{form}"))
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        place = np.full((int(tags.max()) + 1, 3), np.nan)
        place[tags.astype(int)] = xyz.reshape(-1, 3)
        (kind,), (elements,), (nodes,) = gmsh.model.mesh.getElements(3)
        assert kind == (17 if count == 20 else GMSH_TYPES[name])
        theirs = place[nodes.astype(int).reshape(len(cells), count)]
        np.testing.assert_allclose(theirs, data.points[cells[:, :count]], atol=1e-14)
        assert gmsh.model.mesh.getElementQualities(elements, "minDetJac").min() > 0.0
        groups = {gmsh.model.getPhysicalName(d, t): (d, t) for d, t in gmsh.model.getPhysicalGroups()}
        assert set(groups) == ({"a", "b", "low end", "side"} if form == "msh" else {"a", "b"})
        found = gmsh.model.mesh.getElements(3, gmsh.model.getEntitiesForPhysicalGroup(*groups["b"])[0])[1][0]
        np.testing.assert_array_equal(np.searchsorted(elements, found), data.regions["b"])
        if form == "msh":
            entity = gmsh.model.getEntitiesForPhysicalGroup(*groups["low end"])[0]
            ours = data.points[data.boundaries["low end"]]
            corners = place[gmsh.model.mesh.getElements(2, entity)[2][0].astype(int)]
            np.testing.assert_allclose(corners.reshape(ours.shape), ours)
        views = {gmsh.option.getString(f"View[{k}].Name"): tag for k, tag in enumerate(gmsh.view.getTags())}
        kind, at, values, _, width = gmsh.view.getModelData(views["u"], 0)
        assert (kind, width) == ("NodeData", 3)
        np.testing.assert_allclose(np.array(values), place[np.asarray(at, dtype=int)], atol=1e-14)
        kind, at, values, _, _ = gmsh.view.getModelData(views["n"], 0)
        values, inside = np.array(values)[:, 0], np.isin(at, elements)
        assert kind == "ElementData"
        np.testing.assert_array_equal(values[inside], np.arange(len(cells)))
        assert np.all(np.isnan(values[~inside]))  # on the faces of .msh
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("name", ["P2", "Q2"])
def test_fields_and_groups_in_vtu(name, tmp_path: Path):
    data = example(name)
    write_mesh(tmp_path / "c.vtu", data, {"u": data.points}, {"n": np.arange(data.count), "s": np.ones((data.count, 6))})
    again = meshio.read(tmp_path / "c.vtu")
    np.testing.assert_array_equal(again.point_data["u"], again.points)
    np.testing.assert_array_equal(again.cell_data["n"][0], np.arange(data.count))
    assert again.cell_data["s"][0].shape == (data.count, 6)
    np.testing.assert_array_equal(again.cell_data["region"][0], [0, 0, 0] + [1] * (data.count - 3))
    np.testing.assert_array_equal(again.point_data["boundary low end"], data.points[:, 2] < 0.3 + 1e-12)


def test_a_mesh_without_names_is_one_entity_of_msh(tmp_path: Path):
    import gmsh

    data = example("P1")
    write_mesh(tmp_path / "c.msh", MeshData(data.points, data.cells))
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(str(tmp_path / "c.msh"))
        assert gmsh.model.getEntities(3) == [(3, 1)]
        assert [gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()] == ["other"]
    finally:
        gmsh.finalize()
    with pytest.raises(ValueError, match="field 's' has 6 components"):
        write_mesh(tmp_path / "d.msh", data, {"s": np.ones((len(data.points), 6))})
    assert os.listdir(tmp_path) == ["c.msh"]


@pytest.mark.parametrize("name", VOLUMES)
def test_abaqus_keeps_to_its_lines_and_sets(name, tmp_path: Path):
    data = example(name)
    write_mesh(tmp_path / "c.inp", data)
    text = (tmp_path / "c.inp").read_text()
    assert max(len(line.rstrip(",").split(",")) for line in text.splitlines() if line[0] != "*") <= 16
    assert sum(line.endswith(",") for line in text.splitlines()) == (data.count if name == "Q2" else 0)
    again = meshio.read(tmp_path / "c.inp")
    low = np.flatnonzero(again.points[:, 2] < 0.3 + 1e-12)
    np.testing.assert_array_equal(again.point_sets["low_end"], low)
    assert len(again.point_sets["side"]) == len(low)
    np.testing.assert_array_equal(again.cell_sets["b"][0], data.regions["b"])
    assert len(again.cell_sets["EALL"][0]) == data.count
    with pytest.raises(ValueError, match="takes no fields"):
        write_mesh(tmp_path / "d.inp", data, {"u": data.points})
    assert os.listdir(tmp_path) == ["c.inp"]


@pytest.mark.parametrize("name", VOLUMES)
def test_abaqus_has_the_boundaries_as_surfaces(name, tmp_path: Path):
    """Faces S1 to S4 or S6 of its manual, in the numbers of the file's own elements and nodes."""
    data = example(name)
    write_mesh(tmp_path / "c.inp", data)
    again = meshio.read(tmp_path / "c.inp")
    cells = volume_cells(again).data
    sides = {
        "tet": [(1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1)],
        "hex": [(1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)],
    }["tet" if name[0] == "P" else "hex"]
    blocks = (tmp_path / "c.inp").read_text().split("*SURFACE, NAME=")[1:]
    assert [block.split("\n")[0] for block in blocks] == ["low_end, TYPE=ELEMENT", "side, TYPE=ELEMENT"]
    for block, faces in zip(blocks, data.boundaries.values(), strict=True):
        rows = [line.split(", S") for line in block.split("\n")[1:-1]]
        corners = np.array([[cells[int(e) - 1, k - 1] for k in sides[int(s) - 1]] for e, s in rows])
        theirs = again.points[corners].mean(axis=1)
        ours = data.points[faces[:, : len(sides[0])]].mean(axis=1)
        np.testing.assert_allclose(theirs, ours, atol=1e-12)


@pytest.mark.parametrize("name", VOLUMES)
@pytest.mark.parametrize("form", ["vtu", "msh"])
def test_scikit_fem_loads_names(name, form, tmp_path: Path):
    data = example(name)
    data = MeshData(data.points, data.cells, {"body": np.arange(data.count)}, data.boundaries)
    write_mesh(tmp_path / f"c.{form}", data, {"u": data.points}, {"n": np.arange(data.count)})
    mesh = skfem.Mesh.load(tmp_path / f"c.{form}")
    corners = {"P": 3, "Q": 4}[name[0]]
    assert set(mesh.boundaries) == set(data.boundaries)
    for side, faces in data.boundaries.items():
        theirs = mesh.p[:, mesh.facets[:, mesh.boundaries[side]]].mean(axis=1).T
        ours = data.points[faces[:, :corners]].mean(axis=1)
        np.testing.assert_allclose(*(x[np.lexsort(x.round(9).T)] for x in (theirs, ours)), atol=1e-12)
    np.testing.assert_array_equal(mesh.subdomains["body"], np.arange(data.count))


def test_every_group_of_msh_has_a_node_of_its_own():
    nodes = [np.arange(6), np.array([0, 1]), np.array([0, 1]), np.array([1, 2])]
    owner = bridge._owners(nodes, 6)
    assert set(owner) == {0, 1, 2, 3}
    assert all(k in np.flatnonzero([node in group for group in nodes]) for node, k in enumerate(owner))


@pytest.mark.parametrize("name", VOLUMES)
def test_abaqus_files_have_numbers_that_calculix_reads(name, tmp_path: Path):
    data = example(name)
    write_mesh(tmp_path / "c.inp", MeshData(-data.points / 3e7, data.cells))
    lines = [line for line in (tmp_path / "c.inp").read_text().splitlines()[2:] if not line.startswith("*")]
    assert max(len(entry.strip()) for line in lines for entry in line.split(",")) <= 20
    again = meshio.read(tmp_path / "c.inp")
    used = np.unique(volume_cells(again).data)
    np.testing.assert_allclose(again.points[used].min(axis=0), (-data.points / 3e7).min(axis=0), rtol=1e-12)


def test_med_keeps_groups_of_nodes(tmp_path: Path):
    data = example("Q2")
    write_mesh(tmp_path / "c.med", data, {"t": np.arange(len(data.points)), "u": data.points}, {"n": np.arange(data.count)})
    again = meshio.read(tmp_path / "c.med")
    assert {name: values.dtype for name, values in again.point_data.items() if name in "tu"} == {"t": float, "u": float}
    assert again.cell_data["n"][0].dtype == float
    assert sorted(again.field_data["med:nom"]) == [["C1"], ["C1"], ["C1", "C2", "C3"]]
    for name, where in {"low end": again.points[:, 2] < 0.3 + 1e-12, "side": again.points[:, 0] > 1.1 - 1e-12}.items():
        families = [number for number, names in again.point_tags.items() if name in names]
        np.testing.assert_array_equal(np.isin(again.point_data["point_tags"], families), where)
    kept = np.isin(np.arange(len(data.points)), data.cells["Q2"][:, :20])
    np.testing.assert_array_equal(again.point_data["t"], np.flatnonzero(kept))
    assert again.cell_tags[-2] == ["b"]


def test_formats_go_by_the_suffix_unless_given(tmp_path: Path, monkeypatch):
    data = example("P1")
    write_mesh(tmp_path / "mesh.dat", data, form="msh")
    assert (tmp_path / "mesh.dat").read_bytes().startswith(b"$MeshFormat")
    assert form_of(Path("a.VTU")) == "vtu"
    with pytest.raises(ValueError, match=r"suffix '\.stl', expected one of \.vtu, \.msh, \.med, \.inp"):
        form_of(Path("a.stl"))
    with pytest.raises(ValueError, match="format 'stl'"):
        write_mesh(tmp_path / "a.vtu", data, form="stl")
    with pytest.raises(ValueError, match="region 'c' shares cells"):
        write_mesh(tmp_path / "a.vtu", MeshData(data.points, data.cells, {"a": np.arange(3), "c": np.arange(2, 5)}))
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ImportError, match=r"MED files need h5py.*pip install h5py"):
        write_mesh(tmp_path / "a.med", data)
    assert os.listdir(tmp_path) == ["mesh.dat"]


def test_files_are_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch):
    path = tmp_path / "a.vtu"
    path.write_text("before")
    old = os.umask(0o027)
    try:
        write_mesh(path, example("P1"))
    finally:
        os.umask(old)
    assert path.stat().st_mode & 0o777 == 0o640
    whole = path.read_bytes()

    def interrupt(name, *_, **__):
        Path(name).write_text("half")
        raise KeyboardInterrupt

    monkeypatch.setattr(meshio, "write", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_mesh(path, example("P2"))
    assert path.read_bytes() == whole
    assert os.listdir(tmp_path) == ["a.vtu"]


@pytest.mark.parametrize("name", VOLUMES)
def test_faces_turn_left_seen_from_outside(name):
    points, cells = cube(name, 2)
    faces = boundary_faces(cells, name)
    found = from_skfem(mesh_of(points, cells, name, {"all": faces})[0], "all")
    x = found.points[found.boundaries["all"]]
    assert len(x) == len(faces)
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    assert ((normal * (x.mean(axis=1) - 0.5)).sum(axis=1) > 0.0).all()
    if name[1] == "2":
        n = 3 if name == "P2" else 4
        np.testing.assert_allclose(x[:, n : 2 * n], 0.5 * (x[:, :n] + np.roll(x[:, :n], -1, axis=1)), atol=1e-14)
