"""Small structured meshes of the unit cube in the four volume elements, and what the tests measure on meshes of arrays.

Points, cells and faces are arrays in gmsh's order; matrices and vectors are numbered like the points.
"""

from itertools import permutations

import numpy as np
from skfem import Basis, ElementVector, Functional, LinearForm
from skfem.helpers import dot

from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import CachedIsoparametricMap, stiffness_quadrature
from rollbench.meshes.fem import _SKFEM, MESHES, build_mesh, scaled_jacobians

KINDS = ["P1", "P2", "Q1", "Q2"]
#: Nodes of the elements on the unit cell, in gmsh's order.
LOCAL = {kind: MESHES[kind].elem.doflocs[np.argsort(_SKFEM[kind])] for kind in KINDS}
_CORNERS = {
    "P": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    "Q": [[0, 3, 2, 1], [0, 1, 5, 4], [0, 4, 7, 3], [1, 2, 6, 5], [2, 3, 7, 6], [4, 5, 6, 7]],
}


def force(density):
    """Int f . v over cells or faces; density: f, a vector (3,), or a function of the place x (3, ...) -> (3, ...)."""

    def work(v, w):
        f = density(w.x) if callable(density) else np.reshape(density, (3, 1, 1))
        return dot(f, v)

    return LinearForm(work)


def face_nodes(kind):
    """Local nodes of every face, corners first, then the middles of edges, then its own middle; normals outward."""
    local, rows = LOCAL[kind], []
    for corners in _CORNERS[kind[0]]:
        x = local[corners]
        places = [*x]
        if kind[1] == "2":
            places += [*(0.5 * (x + np.roll(x, -1, axis=0)))] + ([x.mean(axis=0)] if kind == "Q2" else [])
        rows.append([int(np.abs(local - p).sum(axis=1).argmin()) for p in places])
    return np.array(rows)


def cube(kind, m):
    """Points and cells of an m x m x m cube; tetrahedra by Kuhn's division of every cell into six."""
    order = int(kind[1])
    n = order * m + 1
    points = np.stack(np.meshgrid(*3 * [np.linspace(0.0, 1.0, n)], indexing="ij"), axis=-1).reshape(-1, 3)
    origin = order * np.stack(np.meshgrid(*3 * [np.arange(m)], indexing="ij"), axis=-1).reshape(-1, 3)
    parts = [LOCAL[kind]]
    if kind[0] == "P":
        parts = []
        for axes in permutations(range(3)):
            corners = np.cumsum([np.zeros(3), *np.eye(3)[list(axes)]], axis=0)
            if np.linalg.det(corners[1:] - corners[0]) < 0.0:
                corners[[2, 3]] = corners[[3, 2]]
            parts.append(corners[0] + LOCAL[kind] @ (corners[1:] - corners[0]))
    where = np.rint(order * np.array(parts)).astype(int)
    places = origin[:, None, None] + where
    cells = np.ravel_multi_index(np.moveaxis(places, -1, 0), (n, n, n)).reshape(-1, len(LOCAL[kind]))
    return points, cells


def distorted(points, amount=0.05):
    """The cube bent smoothly, so that cells of second order are curved."""
    x, y, z = points.T
    bump = np.column_stack([np.sin(2.0 * y + z), x * z + y * y, np.cos(3.0 * x) * y])
    return points + amount * bump


def outer_faces(cells, kind="P2"):
    """Outward faces that belong to one cell only, shape (k, nodes of a face), and how often any face occurs."""
    faces = cells[:, face_nodes(kind)]
    faces = faces.reshape(-1, faces.shape[2])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]], count


def boundary_faces(cells, kind):
    """The same faces alone."""
    return outer_faces(cells, kind)[0]


def space(mesh, **options):
    """Vector space on the mesh's own element, by default at the points of the fast assembly. options: of `skfem.Basis`."""
    options = {"quadrature": stiffness_quadrature(mesh), **options}
    return Basis(mesh, ElementVector(mesh.elem()), CachedIsoparametricMap(mesh), **options)


def freedoms(nodes):
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()


def renumbered(number, values):
    """Values of a mesh's nodes in the order of the points; zero at points of no cell."""
    out = np.zeros((len(number), *np.shape(values)[1:]))
    out[number >= 0] = np.asarray(values)[number[number >= 0]]
    return out


def stiffness(points, cells, kind, young, poisson):
    """Stiffness matrix (3n, 3n), numbered like the points, all of which must have a cell."""
    mesh, number = build_mesh(points, cells, kind)
    order = freedoms(number)
    return forms.elastic_stiffness(mesh, young, poisson)[order][:, order].tocsc()


def volume(points, cells, kind):
    return one(space(build_mesh(points, cells, kind)[0]))


def nodal_areas(points, cells, kind, faces):
    """Consistent nodal areas (n,) of faces (k, corners or more)."""
    mesh, number = build_mesh(points, cells, kind, {"own": faces})
    return renumbered(number, forms.nodal_areas(mesh, "own"))


def jacobians(points, cells, kind):
    return scaled_jacobians(build_mesh(points, cells, kind)[0])


def one(basis):
    """Volume or area of what a basis covers."""
    return float(Functional(lambda w: 1.0 + 0.0 * w.x[0]).assemble(basis))


def volume_of(body):
    """Volume [m3] of a meshed body."""
    return one(space(body.mesh))


def area_of(points, faces):
    """Area of second-order triangles (f, 6), each as four flat ones."""
    a = [points[faces[:, k]] for k in range(6)]
    pieces = ((a[0], a[3], a[5]), (a[3], a[1], a[4]), (a[5], a[4], a[2]), (a[3], a[4], a[5]))
    return sum(0.5 * np.linalg.norm(np.cross(q - p, s - p), axis=1).sum() for p, q, s in pieces)
