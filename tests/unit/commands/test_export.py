"""Meshes as files for other programs: places, order, groups and fields survive, files appear whole or not at all."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from compare.commands import export as export_command
from compare.commands.export import parts_of, run_export
from compare.errors import InputError
from compare.scenes import catalogue
from hifi.assembly import assemble
from hifi.forms import elasticity
from meshes import bridge
from meshes.bridge import FORMATS, MeshData, form_of, from_skfem, reduced, write_mesh
from meshes.fem import mesh_of
from tests.fe_meshes import boundary_faces, cube, jacobians, nodal_areas

pytestmark = pytest.mark.xdist_group("exported meshes")

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
    (block,) = [b for b in mesh.cells if b.dim == 3]
    return block


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
            own = place[gmsh.model.mesh.getElements(2, entity)[2][0].astype(int)]
            np.testing.assert_allclose(own.reshape(ours.shape), ours)
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
        assert gmsh.model.getPhysicalGroups() == []
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
def test_abaqus_files_have_numbers_that_calculix_reads(name, tmp_path: Path):
    data = example(name)
    write_mesh(tmp_path / "c.inp", MeshData(-data.points / 3e7, data.cells))
    lines = [line for line in (tmp_path / "c.inp").read_text().splitlines()[2:] if not line.startswith("*")]
    assert max(len(entry.strip()) for line in lines for entry in line.split(",")) <= 20
    again = meshio.read(tmp_path / "c.inp")
    used = np.unique(volume_cells(again).data)
    np.testing.assert_allclose(again.points[used].min(axis=0), (-data.points / 3e7).min(axis=0), rtol=1e-12)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_finds_the_compliance_of_an_exported_nut(tmp_path: Path):
    """Unit forces on two sockets of the nut, held outside: every node of the sockets moves as in our own elements."""
    scene = catalogue.scene("two-balls")
    run_export(scene, "nut", "inp", tmp_path / "nut.inp", 1, show=lambda _: None)
    mesh = meshio.read(tmp_path / "nut.inp")
    (block,) = [b for b in mesh.cells if b.type == "tetra10"]
    points, cells = mesh.points, block.data[:, np.argsort(bridge._VTK["P2"][1])]
    sockets = mesh.point_sets["sockets"]
    held = np.flatnonzero(np.abs(np.hypot(*points[:, :2].T) - scene.nut.outer_diameter / 2.0) < 1e-7)
    forces = np.zeros((len(points), 3))
    pushed = [sockets[(points[sockets, 0] > 0.0) & (points[sockets, 2] > 7e-3)], sockets[points[sockets, 0] < 0.0]]
    forces[pushed[0], 0], forces[pushed[1], 2] = 1.0 / len(pushed[0]), 1.0 / len(pushed[1])
    mesh_, number = mesh_of(points, cells, "P2")
    assert np.array_equal(number, np.arange(len(points)))
    K = assemble(elasticity(210e9, 0.28), mesh_)
    free = np.setdiff1d(np.arange(3 * len(points)), (3 * held[:, None] + np.arange(3)).ravel())
    ours = np.zeros(3 * len(points))
    ours[free] = spsolve(K[free][:, free], forces.ravel()[free])
    ours = ours.reshape(-1, 3)

    # metres make the forces of the deck's step newtons
    with (tmp_path / "nut.inp").open("a") as deck:
        deck.write("*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, 0.28\n*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL\n*BOUNDARY\n")
        deck.writelines(f"{n + 1}, 1, 3\n" for n in held)
        deck.write("*STEP\n*STATIC\n*CLOAD\n")
        deck.writelines(f"{n + 1}, {k + 1}, {forces[n, k]:.12e}\n" for n, k in np.argwhere(forces))
        deck.write("*NODE PRINT, NSET=sockets\nU\n*END STEP\n")
    subprocess.run([shutil.which("ccx"), "-i", "nut"], cwd=tmp_path, check=True, capture_output=True)
    rows = [line.split() for line in (tmp_path / "nut.dat").read_text().splitlines()]
    theirs = np.zeros_like(ours)
    for node, *u in (row for row in rows if len(row) == 4 and row[0].isdigit()):
        theirs[int(node) - 1] = [float(x) for x in u]
    assert len(np.flatnonzero(theirs.any(axis=1))) == len(sockets)
    largest = np.abs(ours[sockets]).max()
    for own in pushed:
        np.testing.assert_allclose(theirs[own].mean(axis=0), ours[own].mean(axis=0), atol=2e-4 * largest)
    np.testing.assert_allclose(theirs[sockets], ours[sockets], atol=1e-3 * largest)


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


def four_balls():
    """Case 1 cut to four balls in a short nut."""
    s = catalogue.scene("lin-case1")
    return replace(
        s,
        nut=replace(s.nut, position=22e-3, length=34e-3),
        screw=replace(s.screw, length=44e-3),
        balls=replace(s.balls, azimuths=(-2.9, -0.6, 0.4, 2.6)),
        loads=(replace(s.loads[0], force=(0.0, 0.0, 300.0)),),
        supports=(s.supports[0], replace(s.supports[0], at=44e-3, fixed=(("ux", 0.0), ("uy", 0.0)))),
        solid=replace(s.solid, shaft=4e-3, shaft_diameter=30e-3),
    )


SCENE = four_balls()


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def exported(part: str, tmp_path: Path, cache: Path, level: int = 1) -> tuple[meshio.Mesh, str]:
    """The file of a part, read again, and what was said about it."""
    said = []
    assert run_export(SCENE, part, "", tmp_path / part, level, cache=cache, show=said.append) == 0
    return meshio.read(tmp_path / f"{part}.vtu"), "\n".join(said)


def our_cells(mesh: meshio.Mesh) -> tuple[str, np.ndarray]:
    """Element and cells in our order."""
    (block,) = mesh.cells
    name = next(n for n, (kind, _) in bridge._VTK.items() if kind == block.type)
    return name, block.data[:, np.argsort(bridge._VTK[name][1])]


def area(mesh: meshio.Mesh, group: str) -> float:
    """Area of the faces all of whose nodes belong to a group."""
    name, cells = our_cells(mesh)
    faces = boundary_faces(cells, name)
    own = faces[np.all(mesh.point_data[f"boundary {group}"][faces] == 1, axis=1)]
    return float(nodal_areas(mesh.points, cells, name, own).sum())


@pytest.mark.parametrize("part", ["screw", "nut", "ball"])
def test_bodies_with_their_ends_and_sockets(part, tmp_path: Path, cache: Path):
    mesh, said = exported(part, tmp_path, cache)
    name, cells = our_cells(mesh)
    assert name == "P2"
    assert f"{len(mesh.points)} nodes, {len(cells)} 10-node tetrahedra" in said
    assert jacobians(mesh.points, cells, name).min() > 0.0
    edges = np.array([(0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)])
    ends, middle = mesh.points[cells[:, edges]], mesh.points[cells[:, 4:10]]
    away = np.linalg.norm(middle - ends.mean(axis=2), axis=2) / np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2)
    # a few inner edges bend more, where only that keeps a cell beside a socket from being turned inside out
    assert np.mean(away > 0.25) < 1e-4
    assert away.max() < 0.35
    if part == "ball":
        np.testing.assert_allclose(np.linalg.norm(mesh.points, axis=1).max(), SCENE.balls.radius, rtol=1e-9)
        assert area(mesh, "socket SL") == pytest.approx(area(mesh, "socket NR"), rel=0.3)
        return
    low, high = (mesh.point_data[f"boundary {end} end"] == 1 for end in ("low", "high"))
    z = mesh.points[:, 2]
    np.testing.assert_array_equal(low, np.abs(z - z.min()) < 1e-9)
    np.testing.assert_array_equal(high, np.abs(z - z.max()) < 1e-9)
    if part == "nut":
        assert z.max() - z.min() == pytest.approx(SCENE.nut.length, rel=1e-9)
    assert len(list(cache.rglob("output.pkl"))) == 3  # screw, nut and ball, shared with the reference and each other
    assert 0.0 < area(mesh, "sockets") / SCENE.ball_count < 8.0 * SCENE.balls.radius**2


@pytest.mark.parametrize("part", ["patch-SL", "ball-patch-SL", "patch-NR"])
def test_patches_with_their_contact_zone(part, tmp_path: Path, cache: Path):
    mesh, said = exported(part, tmp_path, cache)
    name, cells = our_cells(mesh)
    assert (name, "27-node hexahedra" in said) == ("Q2", True)
    assert jacobians(mesh.points, cells, name).min() > 0.0
    R = SCENE.track.pitch_radius
    contact = mesh.points[mesh.point_data["boundary contact"] == 1]
    centre = np.zeros(3) if part.startswith("ball") else np.array([R, 0.0, 0.0])
    away = np.linalg.norm(contact - centre, axis=1)
    np.testing.assert_allclose(away, SCENE.balls.radius, rtol=0.02 if centre[0] else 1e-9)
    assert away.min() > (1.0 - 1e-9) * SCENE.balls.radius
    inward = np.hypot(*contact[:, :2].T).mean() < R if centre[0] else contact[:, 0].mean() < 0.0
    assert inward == part.endswith("SL")
    assert 0.0 < area(mesh, "contact") < area(mesh, "interface")


def test_patches_of_groove_and_ball_share_their_nodes(tmp_path: Path, cache: Path):
    groove, ball = (exported(part, tmp_path, cache)[0] for part in ("patch-SL", "ball-patch-SL"))
    on_groove = groove.points[groove.point_data["boundary contact"] == 1] - [SCENE.track.pitch_radius, 0.0, 0.0]
    on_ball = ball.points[ball.point_data["boundary contact"] == 1]
    rays = [x / np.linalg.norm(x, axis=1)[:, None] for x in (on_groove, on_ball)]
    np.testing.assert_allclose(*rays, atol=1e-9)


def test_the_source_s_mesh_is_of_first_order(tmp_path: Path, cache: Path):
    mesh, _ = exported("ball", tmp_path, cache, level=0)
    name, cells = our_cells(mesh)
    assert name == "P1"
    assert jacobians(mesh.points, cells, name).min() > 0.0
    assert area(mesh, "socket SL") > 0.0


def test_the_source_s_block(tmp_path: Path):
    mesh, said = exported("block-source", tmp_path, None)
    name, cells = our_cells(mesh)
    assert name == "P1"
    assert "groups: contact" in said
    np.testing.assert_array_equal(mesh.point_data["boundary contact"] == 1, mesh.points[:, 2] < 1e-12)
    assert area(mesh, "contact") == pytest.approx(25e-6)
    near = np.linalg.norm(mesh.points[cells].mean(axis=1), axis=1) < 0.5e-3
    edges = np.linalg.norm(mesh.points[cells[near][:, 1]] - mesh.points[cells[near][:, 0]], axis=1)
    assert np.median(edges) == pytest.approx(0.08e-3, rel=0.25)
    edges = np.linalg.norm(mesh.points[cells[:, 1]] - mesh.points[cells[:, 0]], axis=1)
    assert edges.max() > 1.2e-3


@pytest.mark.parametrize("name", VOLUMES)
def test_faces_turn_left_seen_from_outside(name):
    points, cells = cube(name, 2)
    own = boundary_faces(cells, name)
    found = from_skfem(mesh_of(points, cells, name, {"all": own})[0], "all")
    x = found.points[found.boundaries["all"]]
    assert len(x) == len(own)
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    assert ((normal * (x.mean(axis=1) - 0.5)).sum(axis=1) > 0.0).all()
    if name[1] == "2":
        n = 3 if name == "P2" else 4
        np.testing.assert_allclose(x[:, n : 2 * n], 0.5 * (x[:, :n] + np.roll(x[:, :n], -1, axis=1)), atol=1e-14)


def test_names_and_formats_of_files(tmp_path: Path, cache: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = []
    for form, out in (("", None), ("inp", None), ("", Path("deep/a.msh")), ("msh", Path("b.dat")), ("inp", Path("c"))):
        run_export(SCENE, "patch-SL", form, out, 1, cache=cache, show=said.append)
    found = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file())
    assert found == ["b.dat", "c.inp", "deep/a.msh", "lin-case1-patch-SL.inp", "lin-case1-patch-SL.vtu"]
    assert Path("b.dat").read_bytes()[:11] == b"$MeshFormat"
    assert sum("left out" in line for line in said) == 2


def test_what_cannot_be_exported_is_refused_before_meshing(tmp_path: Path, monkeypatch):
    def never(*_):
        raise AssertionError("meshed")

    monkeypatch.setattr(export_command, "part_mesh", never)
    assert parts_of(SCENE) == (
        "screw",
        "nut",
        "ball",
        "patch-SL",
        "patch-NR",
        "ball-patch-SL",
        "ball-patch-NR",
        "block-source",
    )
    out = tmp_path / "a.vtu"
    with pytest.raises(InputError, match=r"part: got patch-SR; allowed: screw, nut, ball, patch-SL, patch-NR"):
        run_export(SCENE, "patch-SR", "", out, 1)
    with pytest.raises(InputError, match=r"--format: got step; allowed: vtu, msh, med, inp"):
        run_export(SCENE, "screw", "step", tmp_path / "a", 1)
    with pytest.raises(InputError, match=r"--out: got .*a\.stl; allowed: a name ending in \.vtu, \.msh, \.med, \.inp"):
        run_export(SCENE, "screw", "", tmp_path / "a.stl", 1)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"--format: got med; .*pip install h5py"):
        run_export(SCENE, "screw", "", tmp_path / "a.med", 1)
    assert os.listdir(tmp_path) == []


def test_meshes_and_files_that_fail_are_reported(tmp_path: Path, cache: Path, monkeypatch):
    with pytest.raises(InputError, match="--levels: got 9"):
        run_export(SCENE, "screw", "", tmp_path / "a.vtu", 9)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"a\.vtu: file: got "):
        run_export(SCENE, "patch-SL", "", tmp_path / "file" / "a.vtu", 1, cache=cache, show=lambda _: None)

    def bad(*_):
        raise ValueError("a contact patch does not fit")

    monkeypatch.setattr(export_command, "part_mesh", bad)
    with pytest.raises(InputError, match="lin-case1: screw: a contact patch does not fit"):
        run_export(SCENE, "screw", "", tmp_path / "a.vtu", 1)


class TestResults:
    """Result fields of the scene, solved with the meshes of the tests before."""

    def test_nut_and_ball_carry_displacement_and_stress(self, tmp_path, cache):
        lines = []
        for part in ("nut", "ball", "patch-NR"):
            out = tmp_path / f"{part}.vtu"
            run_export(SCENE, part, "", out, 1, cache=cache, show=lines.append, ball=2)
            read = meshio.read(out)
            u, stress = read.point_data["displacement"], read.point_data["von_mises"]
            assert u.shape == (len(read.points), 3)
            assert 1e-8 < np.abs(u).max() < 1e-4
            assert (stress >= 0.0).all()
            if part == "nut":
                held = np.abs(read.points[:, 2] - 5e-3) < 1e-9
                assert held.any()
                assert (u[held] == 0.0).all()
            if part == "patch-NR":
                assert stress.max() > 5e8  # below a contact of some 100 N

    def test_what_cannot_be_had_is_refused(self, tmp_path):
        for part, ball, form in (("nut", 0, ""), ("nut", 5, ""), ("block-source", 1, ""), ("nut", 1, "inp")):
            with pytest.raises(InputError, match="--ball"):
                run_export(SCENE, part, form, tmp_path / "a", 1, ball=ball)
        with pytest.raises(InputError, match="low end"):
            run_export(SCENE, "screw", "", tmp_path / "a.vtu", 1, cache=cache, ball=1)
        assert not (tmp_path / "a.vtu").exists()
