"""Mesh files for other programs: places, order, groups and fields survive, files appear whole or not at all."""

import os
from pathlib import Path

import meshio
import numpy as np
import pytest
import skfem
from tests.fe_meshes import KINDS, boundary_faces, cube

from rollbench.meshes.exchange.mesh_files import FORMATS, loses_nodes_in_format, write_mesh
from rollbench.meshes.fem import build_mesh, node_coordinates, nodes_of_boundary_faces, nodes_of_cells

EDGES = {
    10: [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    20: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
}
EDGES[27] = EDGES[20]
FACES_27 = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]


def example(name: str) -> skfem.Mesh:
    """A cube with two named sides that share an edge; its cells of second order are straight."""
    points, cells = cube(name, 2)
    faces = boundary_faces(cells, name)
    x, _, z = points[faces].transpose(2, 0, 1)
    sides = {"low end": faces[np.all(z < 1e-12, axis=1)], "side": faces[np.all(x > 1.0 - 1e-12, axis=1)]}
    return build_mesh(points + np.array([0.1, 0.2, 0.3]), cells, name, sides)[0]


def ordered(points: np.ndarray, cells: np.ndarray, turned: bool = False) -> None:
    """Assert that cells are ordered as Abaqus' and VTK's manuals draw them; turned: seen in a mirror, as MED's."""
    x = points[cells]
    third, fourth, corners = (2, 3, 4) if cells.shape[1] in (4, 10) else (3, 4, 8)
    det = np.linalg.det(x[:, [1, third, fourth]] - x[:, :1])
    assert np.all((-det if turned else det) > 0.0)
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
    (block,) = (b for b in mesh.cells if b.dim == 3)
    return block


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("form", FORMATS)
def test_cells_are_where_they_were(form, name, tmp_path: Path):
    import pyvista

    mesh, path = example(name), tmp_path / f"cube.{form}"
    write_mesh(path, mesh)
    again = meshio.read(path)
    block = volume_cells(again)
    ordered(again.points, block.data, turned=form == "med")
    cells = nodes_of_cells(mesh)
    assert block.data.shape == (len(cells), 20 if loses_nodes_in_format(mesh, form) else cells.shape[1])
    ours = node_coordinates(mesh)[cells[:, : {"P": 4, "Q": 8}[name[0]]]]
    theirs = again.points[block.data[:, : ours.shape[1]]]
    np.testing.assert_allclose(theirs.mean(axis=1), ours.mean(axis=1), atol=1e-12)
    used = np.unique(np.concatenate([b.data.ravel() for b in again.cells]))
    np.testing.assert_array_equal(used, range(len(again.points)))
    if form == "vtu":
        assert abs(pyvista.read(path).volume) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", ["P2", "Q2"])
def test_fields_and_groups_in_vtu(name, tmp_path: Path):
    mesh = example(name)
    points = node_coordinates(mesh)
    write_mesh(tmp_path / "c.vtu", mesh, {"u": points, "s": np.ones((len(points), 6))}, region="body")
    again = meshio.read(tmp_path / "c.vtu")
    np.testing.assert_array_equal(again.point_data["u"], again.points)
    assert again.point_data["s"].shape == (len(points), 6)
    np.testing.assert_array_equal(again.cell_data["region"][0], np.zeros(mesh.nelements))
    np.testing.assert_array_equal(again.point_data["boundary low end"], points[:, 2] < 0.3 + 1e-12)


@pytest.mark.parametrize("name", KINDS)
def test_abaqus_keeps_to_its_lines_sets_and_surfaces(name, tmp_path: Path):
    """Faces S1 to S4 or S6 of its manual, in the numbers of the file's own elements and nodes."""
    mesh = example(name)
    write_mesh(tmp_path / "c.inp", mesh, region="body")
    text = (tmp_path / "c.inp").read_text()
    rows = [line for line in text.splitlines() if line[0] != "*"]
    assert max(len(line.rstrip(",").split(",")) for line in rows) <= 16
    assert sum(line.endswith(",") for line in rows) == (mesh.nelements if name == "Q2" else 0)
    again = meshio.read(tmp_path / "c.inp")
    low = np.flatnonzero(again.points[:, 2] < 0.3 + 1e-12)
    np.testing.assert_array_equal(again.point_sets["low_end"], low)
    assert len(again.point_sets["side"]) == len(low)
    for cells in ("body", "EALL"):
        np.testing.assert_array_equal(again.cell_sets[cells][0], np.arange(mesh.nelements))
    cells = volume_cells(again).data
    sides = {
        "P": [(1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1)],
        "Q": [(1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)],
    }[name[0]]
    blocks = text.split("*SURFACE, NAME=")[1:]
    assert [block.split("\n")[0] for block in blocks] == ["low_end, TYPE=ELEMENT", "side, TYPE=ELEMENT"]
    for block, side in zip(blocks, mesh.boundaries, strict=True):
        found = [line.split(", S") for line in block.split("\n")[1:-1]]
        corners = np.array([[cells[int(e) - 1, k - 1] for k in sides[int(s) - 1]] for e, s in found])
        ours = node_coordinates(mesh)[nodes_of_boundary_faces(mesh, side)[:, : len(sides[0])]].mean(axis=1)
        np.testing.assert_allclose(again.points[corners].mean(axis=1), ours, atol=1e-12)


def test_med_keeps_groups_of_nodes_and_faces(tmp_path: Path):
    """Also of faces that two boundaries share: each is in the file once."""
    mesh = example("Q2")
    points = node_coordinates(mesh)
    mesh.boundaries["both"] = np.concatenate([mesh.boundaries[side][:1] for side in ("side", "low end")])
    write_mesh(tmp_path / "c.med", mesh, {"t": np.arange(len(points)), "u": points}, region="body")
    again = meshio.read(tmp_path / "c.med")
    assert {name: values.dtype for name, values in again.point_data.items() if name in "tu"} == {"t": float, "u": float}
    assert sorted(again.field_data["med:nom"]) == [["C1"], ["C1", "C2", "C3"]]
    for name, where in {"low end": again.points[:, 2] < 0.3 + 1e-12, "side": again.points[:, 0] > 1.1 - 1e-12}.items():
        families = [number for number, names in again.point_tags.items() if name in names]
        np.testing.assert_array_equal(np.isin(again.point_data["point_tags"], families), where)
    kept = np.isin(np.arange(len(points)), nodes_of_cells(mesh)[:, :20])
    np.testing.assert_array_equal(again.point_data["t"], np.flatnonzero(kept))
    assert again.cell_tags[-1] == ["body"]
    (quads,) = (block for block in again.cells if block.dim == 2)
    assert len(quads.data) == len(mesh.boundaries["side"]) + len(mesh.boundaries["low end"])
    tags = again.cell_data["cell_tags"][[block.type for block in again.cells].index(quads.type)]
    inside = {name: np.array([name in again.cell_tags[tag] for tag in tags]) for name in mesh.boundaries}
    for name, (axis, place) in {"low end": (2, 0.3), "side": (0, 1.1)}.items():
        where = np.all(np.abs(again.points[quads.data][:, :, axis] - place) < 1e-12, axis=1)
        np.testing.assert_array_equal(inside[name], where)
    assert {name: faces.sum() for name, faces in inside.items()} == {name: len(x) for name, x in mesh.boundaries.items()}


def test_fields_that_do_not_fit_are_refused(tmp_path: Path):
    mesh = example("P1")
    for name, options, why in (
        ("a.vtu", {"fields": {"p": np.zeros(3)}}, "field 'p' has 3 values"),
        ("a.msh", {"fields": {"s": np.ones((mesh.nvertices, 6))}}, "field 's' has 6 components"),
        ("a.inp", {"fields": {"u": node_coordinates(mesh)}}, "cannot contain fields"),
    ):
        with pytest.raises(ValueError, match=why):
            write_mesh(tmp_path / name, mesh, **options)
    assert os.listdir(tmp_path) == []


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
