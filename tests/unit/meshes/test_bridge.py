"""gmsh -> arrays -> scikit-fem and files: names, node orders and volumes survive."""

from pathlib import Path

import meshio
import numpy as np
import pytest
from skfem import MeshHex1, MeshHex2, MeshTet1, MeshTet2
from tests.fe_meshes import KINDS, boundary_faces, cube, jacobians, one, order_of, space

from rollbench.hifi.elements.assembly import faces, nodal_areas
from rollbench.meshes import bridge
from rollbench.meshes.bridge import MeshData, from_gmsh, from_skfem, to_skfem, write_mesh
from rollbench.meshes.fem import mesh_of, second_order

VOLUMES = KINDS
GMSH_TYPES = {"P1": 4, "P2": 11, "Q1": 5, "Q2": 12}


@pytest.fixture
def gmsh():
    import gmsh

    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


def model(gmsh, name, groups=True):
    """Half of a thick tube in two regions (z below and above 0), its bore named; curved in second order."""
    occ = gmsh.model.occ
    bodies = []
    for z in (-1.0, 0.0):
        face = occ.addRectangle(1.0, 0.0, z, 1.0, 1.0)
        occ.rotate([(2, face)], 1.0, 0.0, z, 1.0, 0.0, 0.0, np.pi / 2)
        hexes = name[0] == "Q"
        out = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, np.pi / 2, numElements=[3] if hexes else [], recombine=hexes)
        bodies.append(next(tag for dim, tag in out if dim == 3))
    occ.fragment([(3, bodies[0])], [(3, bodies[1])])
    occ.synchronize()
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    if groups:
        for tag in volumes:
            z = gmsh.model.occ.getCenterOfMass(3, tag)[2]
            gmsh.model.addPhysicalGroup(3, [tag], name="upper" if z > 0 else "lower")
        bore = [t for d, t in gmsh.model.getEntities(2) if abs(radius(gmsh, t) - 1.0) < 1e-6]
        gmsh.model.addPhysicalGroup(2, bore, name="bore")
    if name[0] == "Q":
        for _, tag in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(tag, 4)
        for _, tag in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(2, tag)
        for tag in volumes:
            gmsh.model.mesh.setTransfiniteVolume(tag)
    else:
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order_of(name))


def radius(gmsh, tag):
    """Radius of the middle of a surface."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    x = gmsh.model.getValue(2, tag, [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])])
    return np.hypot(x[0], x[1])


@pytest.mark.parametrize("name", VOLUMES)
def test_regions_boundaries_and_shape_survive(gmsh, name):
    model(gmsh, name)
    data = from_gmsh(regions=["lower", "upper"], boundaries=["bore"])
    assert list(data.cells) == [name]
    cells = data.cells[name]
    assert jacobians(data.points, cells, name).min() > 0.1
    tolerance = 0.05 if order_of(name) == 1 else 1e-3
    mesh = to_skfem(data, name)
    assert one(space(mesh)) == pytest.approx(2 * 0.75 * np.pi, rel=tolerance)
    assert nodal_areas(mesh, "bore").sum() == pytest.approx(np.pi, rel=tolerance)
    np.testing.assert_allclose(np.hypot(*data.points[data.boundaries["bore"]].reshape(-1, 3)[:, :2].T), 1.0, rtol=1e-9)
    height = data.points[cells].mean(axis=1)[:, 2]
    np.testing.assert_array_equal(data.regions["upper"], np.flatnonzero(height > 0.0))
    np.testing.assert_array_equal(data.regions["lower"], np.flatnonzero(height < 0.0))


@pytest.mark.parametrize("name", VOLUMES)
def test_scikit_fem_sees_the_same_body_and_gives_it_back(gmsh, name):
    model(gmsh, name)
    data = from_gmsh()
    mesh = to_skfem(data, name)
    halves = [one(space(mesh, elements=region)) for region in data.regions]
    assert halves == pytest.approx(2 * [0.5 * one(space(mesh))], rel=1e-3)
    x = data.points[data.boundaries["bore"]]
    assert len(mesh.boundaries["bore"]) == len(x)
    assert one(faces(mesh, "bore")) == pytest.approx(np.pi, rel=0.05)
    again = from_skfem(mesh, "bore")
    np.testing.assert_allclose(again.points[again.cells[name]], data.points[data.cells[name]], atol=1e-15)
    for region, cells in data.regions.items():
        np.testing.assert_array_equal(again.regions[region], cells)
    ours = {tuple(np.sort(f)) for f in np.round(again.points[again.boundaries["bore"]], 9).sum(axis=2)}
    assert ours == {tuple(np.sort(f)) for f in np.round(x, 9).sum(axis=2)}


def test_lost_names_are_refused(gmsh):
    with pytest.raises(ValueError, match="no volume cells"):
        from_gmsh()
    model(gmsh, "P2")
    with pytest.raises(ValueError, match=r"region middle lost.*lower, upper"):
        from_gmsh(regions=["middle"])
    with pytest.raises(ValueError, match="boundary end lost"):
        from_gmsh(boundaries=["end", "bore"])
    spare = gmsh.model.addDiscreteEntity(2)
    group = gmsh.model.addPhysicalGroup(2, [spare], name="spare")
    with pytest.raises(ValueError, match="boundary 'spare' is empty"):
        from_gmsh()
    gmsh.model.removePhysicalGroups([(2, group)])
    gmsh.model.addPhysicalGroup(2, [spare])
    with pytest.raises(ValueError, match="has no name"):
        from_gmsh()


def test_strange_cells_and_faces_are_refused(gmsh):
    model(gmsh, "P1", groups=False)
    gmsh.model.mesh.setOrder(3)
    with pytest.raises(ValueError, match=r"gmsh's types \[29\]"):
        from_gmsh()
    points, cells = cube("P2", 1)
    inner = cells[:1, [0, 1, 2, 4, 5, 6]] + 0
    inner[0, 0] = np.setdiff1d(cells, cells[0])[0]
    with pytest.raises(ValueError, match="1 of 1 faces belong to no cell"):
        bridge.check(MeshData(points, {"P2": cells}, {}, {"skew": inner}))
    with pytest.raises(ValueError, match="region 'none' is empty"):
        bridge.check(MeshData(points, {"P2": cells}, {"none": np.array([], dtype=int)}))


def test_scikit_fem_gets_one_kind_and_every_boundary():
    points, cells = cube("P2", 1)
    with pytest.raises(ValueError, match="asked for Q2"):
        to_skfem(MeshData(points, {"P2": cells}), "Q2")
    foreign = cells[:1, :6].copy()
    foreign[0, 0] = np.setdiff1d(cells[:, :4], cells[0])[0]
    with pytest.raises(ValueError, match="'foreign' lost"):
        to_skfem(MeshData(points, {"P2": cells}, {}, {"foreign": foreign}), "P2")


@pytest.mark.parametrize("name", VOLUMES)
def test_boundaries_of_every_element_reach_scikit_fem(name):
    points, cells = cube(name, 2)
    faces = boundary_faces(cells, name)
    top = faces[np.all(points[faces][:, :, 2] > 1 - 1e-12, axis=1)]
    data = MeshData(points, {name: cells}, {"half": np.arange(3)}, {"top": top})
    mesh = to_skfem(data, name)
    assert len(mesh.boundaries["top"]) == len(top)
    np.testing.assert_allclose(mesh.p[2, mesh.facets[:, mesh.boundaries["top"]]], 1.0)
    np.testing.assert_array_equal(mesh.subdomains["half"], np.arange(3))


@pytest.mark.parametrize("name", VOLUMES)
def test_cells_are_ordered_as_meshio_reads_gmsh_s_own_file(gmsh, name, tmp_path: Path):
    model(gmsh, name)
    data = from_gmsh()
    gmsh.write(str(tmp_path / "theirs.msh"))
    theirs = meshio.read(tmp_path / "theirs.msh")
    write_mesh(tmp_path / "ours.vtu", data, {"x": data.points}, {"height": np.arange(data.count, dtype=float)})
    ours = meshio.read(tmp_path / "ours.vtu")
    (block,) = ours.cells
    reference = np.vstack([b.data for b in theirs.cells if b.type == block.type])
    np.testing.assert_allclose(ours.points[block.data], theirs.points[reference], atol=1e-12)
    np.testing.assert_allclose(ours.point_data["x"], ours.points)
    np.testing.assert_array_equal(ours.cell_data["height"][0], np.arange(data.count))
    upper = list(data.regions).index("upper")
    np.testing.assert_array_equal(np.flatnonzero(ours.cell_data["region"][0] == upper), data.regions["upper"])


@pytest.mark.parametrize("name", VOLUMES)
def test_vtk_measures_the_same_volume(name, tmp_path: Path):
    import pyvista

    points, cells = cube(name, 2)
    write_mesh(tmp_path / "cube.vtu", MeshData(points, {name: cells}))
    grid = pyvista.read(tmp_path / "cube.vtu")
    assert grid.n_cells == len(cells)
    assert abs(grid.volume) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", VOLUMES)
def test_exchange_formats_are_read_back(gmsh, name, tmp_path: Path):
    points, cells = cube(name, 2)
    data = MeshData(points, {name: cells}, {"all": np.arange(len(cells))})
    write_mesh(tmp_path / "cube.msh", data, {"x": points})
    gmsh.open(str(tmp_path / "cube.msh"))
    again = gmsh.model.mesh.getElements(3)
    assert list(again[0]) == [GMSH_TYPES[name]]
    np.testing.assert_array_equal(again[2][0].reshape(cells.shape) - 1, cells)
    write_mesh(tmp_path / "cube.inp", data)
    kind = {"P1": "C3D4", "P2": "C3D10", "Q1": "C3D8", "Q2": "C3D20"}[name]
    assert f"TYPE={kind}\n" in (tmp_path / "cube.inp").read_text()
    assert sum(len(b.data) for b in meshio.read(tmp_path / "cube.inp").cells) == len(cells)


def test_files_refuse_strange_suffixes_and_fields(tmp_path: Path):
    points, cells = cube("P1", 1)
    data = MeshData(points, {"P1": cells})
    with pytest.raises(ValueError, match=r"suffix '\.stl'"):
        write_mesh(tmp_path / "cube.stl", data)
    with pytest.raises(ValueError, match="field 'p' has 3 values"):
        write_mesh(tmp_path / "cube.vtu", data, {"p": np.zeros(3)})
    with pytest.raises(ValueError, match="field 'p' has 3 values"):
        write_mesh(tmp_path / "cube.vtu", data, {}, {"p": np.zeros(3)})


@pytest.mark.parametrize("kind", KINDS)
def test_edges_and_faces_are_numbered_as_scikit_fem_does(kind):
    mesh, _ = mesh_of(*cube(kind, 3), kind)
    theirs = {"P1": MeshTet1, "P2": MeshTet2, "Q1": MeshHex1, "Q2": MeshHex2}[kind](mesh.doflocs, mesh.t)
    for name in ("facets", "t2f", "f2t", "edges", "t2e", "f2e"):
        np.testing.assert_array_equal(getattr(mesh, name), getattr(theirs, name), name)
    if kind[1] == "1":
        finer, wanted = second_order(mesh), {"P": MeshTet2, "Q": MeshHex2}[kind[0]].from_mesh(theirs)
        np.testing.assert_array_equal(finer.dofs.element_dofs, wanted.dofs.element_dofs)
        np.testing.assert_array_equal(finer.doflocs, wanted.doflocs)
