"""Small structured meshes of the unit cube in the four volume elements, for the tests of the finite-element core."""

from itertools import permutations

import numpy as np

from hifi.elements import ELEMENTS


def cube(name, m):
    """Points and cells of an m x m x m cube; tetrahedra by Kuhn's division of every cell into six."""
    e = ELEMENTS[name]
    n = e.order * m + 1
    points = np.stack(np.meshgrid(*3 * [np.linspace(0.0, 1.0, n)], indexing="ij"), axis=-1).reshape(-1, 3)
    origin = e.order * np.stack(np.meshgrid(*3 * [np.arange(m)], indexing="ij"), axis=-1).reshape(-1, 3)
    if e.simplex:
        parts = []
        for axes in permutations(range(3)):
            corners = np.cumsum([np.zeros(3), *np.eye(3)[list(axes)]], axis=0)
            if np.linalg.det(corners[1:] - corners[0]) < 0.0:
                corners[[2, 3]] = corners[[3, 2]]
            parts.append(ELEMENTS["P1"].shape(e.local) @ corners)
    else:
        parts = [0.5 * (e.local + 1.0)]
    where = np.rint(e.order * np.array(parts)).astype(int)
    places = origin[:, None, None] + where
    cells = np.ravel_multi_index(np.moveaxis(places, -1, 0), (n, n, n)).reshape(-1, e.nodes)
    return points, cells


def distorted(points, amount=0.05):
    """The cube bent smoothly, so that cells of second order are curved."""
    x, y, z = points.T
    bump = np.column_stack([np.sin(2.0 * y + z), x * z + y * y, np.cos(3.0 * x) * y])
    return points + amount * bump


def boundary(points):
    """Nodes on the surface of the undistorted unit cube."""
    return np.flatnonzero(np.any((points < 1e-12) | (points > 1.0 - 1e-12), axis=1))


def boundary_faces(cells, name):
    """Outward faces that belong to one cell only, shape (k, nodes of a face)."""
    e = ELEMENTS[name]
    faces = cells[:, e.face_nodes()].reshape(-1, ELEMENTS[e.face].nodes)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def freedoms(nodes):
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
