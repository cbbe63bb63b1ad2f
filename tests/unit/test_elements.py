"""Reference elements: shape functions, gradients, quadrature and gmsh's node order."""

from itertools import product
from math import factorial

import numpy as np
import pytest

from hifi.elements import ELEMENTS, element_of

NAMES = list(ELEMENTS)
VOLUMES = [name for name, e in ELEMENTS.items() if e.face]


def inside(element, count=9):
    """Random points inside the reference cell."""
    x = np.random.default_rng(3).random((count, element.dimension))
    return x / element.dimension if element.simplex else 2.0 * x - 1.0


@pytest.fixture(scope="module")
def gmsh_nodes():
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        found = {e.name: gmsh.model.mesh.getElementProperties(e.gmsh_type) for e in ELEMENTS.values()}
        faces = {}
        for name in VOLUMES:
            gmsh.model.add(name)
            tag = gmsh.model.addDiscreteEntity(3)
            e = ELEMENTS[name]
            gmsh.model.mesh.addNodes(3, tag, np.arange(1, e.nodes + 1), e.local.ravel())
            gmsh.model.mesh.addElementsByType(tag, e.gmsh_type, [1], np.arange(1, e.nodes + 1))
            corners = 3 if e.simplex else 4
            faces[name] = gmsh.model.mesh.getElementFaceNodes(e.gmsh_type, corners)
    finally:
        gmsh.finalize()
    return found, faces


@pytest.mark.parametrize("name", NAMES)
def test_node_order_is_gmsh_s(name, gmsh_nodes):
    _, dimension, order, nodes, local, primary = gmsh_nodes[0][name]
    e = ELEMENTS[name]
    assert (dimension, order, nodes, primary) == (e.dimension, e.order, e.nodes, e.corners)
    np.testing.assert_array_equal(local.reshape(nodes, dimension), e.local)


@pytest.mark.parametrize("name", VOLUMES)
def test_faces_hold_the_nodes_of_gmsh_s_faces(name, gmsh_nodes):
    ours = ELEMENTS[name].face_nodes()
    theirs = np.asarray(gmsh_nodes[1][name], dtype=int).reshape(ours.shape) - 1
    assert sorted(map(sorted, ours.tolist())) == sorted(map(sorted, theirs.tolist()))


@pytest.mark.parametrize("name", VOLUMES)
def test_faces_point_outward_and_close_the_cell(name):
    e, face = ELEMENTS[name], ELEMENTS[ELEMENTS[name].face]
    points, weights = face.rule()
    flux = 0.0
    for nodes in e.face_nodes():
        where = face.shape(points) @ e.local[nodes]
        slope = np.einsum("qad,ai->qid", face.gradient(points), e.local[nodes])
        flux += np.sum(weights[:, None] * where * np.cross(slope[..., 0], slope[..., 1]))
    assert flux / 3.0 == pytest.approx(1.0 / 6.0 if e.simplex else 8.0, rel=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_shape_functions_are_nodal_and_sum_to_one(name):
    e = ELEMENTS[name]
    np.testing.assert_allclose(e.shape(e.local), np.eye(e.nodes), atol=1e-15)
    np.testing.assert_allclose(e.shape(inside(e)).sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(e.gradient(inside(e)).sum(axis=1), 0.0, atol=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_shape_functions_reproduce_polynomials_of_their_order(name):
    e = ELEMENTS[name]
    x = inside(e)
    f = lambda p: (1.0 + p @ np.arange(1, e.dimension + 1)) ** e.order  # noqa: E731
    np.testing.assert_allclose(e.shape(x) @ f(e.local), f(x), rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_gradients_by_central_differences(name):
    e = ELEMENTS[name]
    x, h = inside(e), 1e-5
    for k, step in enumerate(h * np.eye(e.dimension)):
        slope = (e.shape(x + step) - e.shape(x - step)) / (2.0 * h)
        np.testing.assert_allclose(e.gradient(x)[:, :, k], slope, atol=1e-10)


@pytest.mark.parametrize("degree", range(9))
@pytest.mark.parametrize("name", ["P1", "triangle3", "Q1", "quad4"])
def test_quadrature_is_exact_positive_and_inside(name, degree):
    e = ELEMENTS[name]
    points, weights = e.rule(degree)
    assert np.all(weights > 0.0)
    if e.simplex:
        assert points.min() > 0.0
        assert points.sum(axis=1).max() < 1.0
    else:
        assert np.abs(points).max() < 1.0
    for powers in product(range(degree + 1), repeat=e.dimension):
        if e.simplex and sum(powers) > degree:
            continue
        if e.simplex:
            exact = np.prod([factorial(p) for p in powers]) / factorial(sum(powers) + e.dimension)
        else:
            exact = np.prod([(1.0 - (-1.0) ** (p + 1)) / (p + 1) for p in powers])
        assert weights @ np.prod(points ** np.array(powers), axis=1) == pytest.approx(exact, rel=1e-13, abs=1e-14)


def test_unknown_names_and_degrees_are_refused():
    with pytest.raises(ValueError, match="'P3' is unknown"):
        element_of("P3")
    with pytest.raises(ValueError, match="degree -1"):
        ELEMENTS["P1"].rule(-1)
    with pytest.raises(ValueError, match="no face"):
        ELEMENTS["quad4"].face_nodes()
