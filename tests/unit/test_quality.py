"""Measures of meshes: scaled Jacobians against the elements of the 3D model, mending, refusal, elements across."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from hifi.elasticity import check_jacobians
from hifi.elements import ELEMENTS
from meshes import quality
from meshes.quality import (
    Quality,
    arc_deviation,
    elements_across,
    measure,
    reference_nodes,
    refuse_bad,
    scaled_jacobians,
    straighten,
    untangle,
)

KINDS = ["P1", "P2", "Q1", "Q2"]
REGULAR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])[[0, 2, 1, 3]]


def with_middles(corners):
    """Ten nodes of a straight tetrahedron."""
    return np.vstack([corners, [0.5 * (corners[i] + corners[j]) for i, j in quality.TET_EDGES]])


@pytest.fixture(scope="module")
def shaken():
    """Many moderately distorted cells of every kind: points and cells."""
    random = np.random.default_rng(3)
    found = {}
    for kind in KINDS:
        local = reference_nodes(kind)
        points = (local[None] @ random.normal(size=(40, 3, 3))) + 0.04 * random.normal(size=(40, len(local), 3))
        found[kind] = points.reshape(-1, 3), np.arange(40 * len(local)).reshape(40, -1)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_nodes_and_gradients_are_those_of_the_elements(kind):
    element = ELEMENTS[kind]
    np.testing.assert_array_equal(reference_nodes(kind), element.local)
    at = np.random.default_rng(1).uniform(0.0, 0.4, (20, 3))
    np.testing.assert_allclose(quality._gradients(kind, at), element.gradient(at), atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_scaled_jacobians_of_regular_and_sheared_cells(kind):
    local = reference_nodes(kind)
    cells = np.arange(len(local))[None]
    shape = (REGULAR[1:] - REGULAR[0]).T if kind[0] == "P" else np.eye(3)
    assert scaled_jacobians(7e-3 * local @ shape.T, cells, kind) == pytest.approx(1.0, abs=1e-13)
    assert scaled_jacobians(local @ shape.T * [1.0, 1.0, -1.0], cells, kind) == pytest.approx(-1.0, abs=1e-13)
    if kind[0] == "Q":
        assert scaled_jacobians(local @ [[1, 0, 0], [1, 1, 0], [0, 0, 1]], cells, kind) == pytest.approx(np.sqrt(0.5))
    else:  # three edges of length 1 meet at right angles in one corner; the largest product is 1 sqrt(2) sqrt(2)
        assert scaled_jacobians(local, cells, kind) == pytest.approx(np.sqrt(2.0) / 2.0)


@pytest.mark.parametrize("kind", KINDS)
def test_scaled_jacobians_agree_with_the_solvers_check(shaken, kind):
    """The solver also looks at quadrature points: it finds the same or less, and the same in first-order tetrahedra."""
    points, cells = shaken[kind]
    own, theirs = scaled_jacobians(points, cells, kind), check_jacobians(points, cells, kind)
    assert np.all(theirs <= own + 1e-12)
    same = np.abs(own - theirs) < 1e-12
    assert same.all() if kind == "P1" else same.mean() > 0.6


def test_chunks_change_nothing(shaken, monkeypatch):
    for kind, (points, cells) in shaken.items():
        whole = scaled_jacobians(points, cells, kind)
        monkeypatch.setattr(quality, "CHUNK", 7)
        np.testing.assert_array_equal(scaled_jacobians(points, cells, kind), whole)
        monkeypatch.undo()


@pytest.mark.parametrize("kind", ["P2", "Q2"])
def test_many_cells_need_little_memory(shaken, kind):
    points, cells = shaken[kind]
    many = np.tile(cells, (1500, 1))  # 60,000 cells
    tracemalloc.start()
    found = scaled_jacobians(points, many, kind)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.size == 60_000
    assert peak < 200e6


def test_measure_counts_and_places_the_worst_cell():
    flat = REGULAR.copy()
    flat[3] = flat[:3].mean(axis=0) + 0.02 * (flat[3] - flat[:3].mean(axis=0))
    points = np.concatenate([REGULAR, REGULAR + 5.0, flat - 5.0])
    found = measure(points, np.arange(12).reshape(3, 4), "P1")
    assert (found.cells, found.nodes, found.worst) == (3, 12, 2)
    assert found.median == pytest.approx(1.0)
    assert found.poor == pytest.approx(1.0 / 3.0)
    assert 0.0 < found.smallest < 0.1
    np.testing.assert_allclose(found.where, points[8:].mean(axis=0))


@pytest.mark.parametrize(("cells", "kind"), [(np.zeros((2, 10), dtype=int), "P1"), (np.zeros((2, 4), dtype=int), "T3")])
def test_wrong_cells_are_refused(cells, kind):
    with pytest.raises(ValueError, match="P1"):
        scaled_jacobians(np.zeros((4, 3)), cells, kind)


def test_empty_mesh_is_refused():
    with pytest.raises(ValueError, match="no cells"):
        measure(np.zeros((4, 3)), np.zeros((0, 4), dtype=int), "P1")


@pytest.mark.parametrize(
    ("smallest", "least", "word"), [(-0.2, 0.0, "inside out"), (0.0, 0.0, "inside out"), (0.03, 0.05, "flat")]
)
def test_bad_mesh_is_refused_with_place_and_remedy(smallest, least, word):
    bad = Quality(10, 20, smallest, 0.5, 0.1, 4, (3e-3, 4e-3, 0.1))
    with pytest.raises(ValueError, match=rf"screw: cell 4 of 10 at r = 5 mm, z = 100 mm.*{word}.*smaller element sizes"):
        refuse_bad(bad, "screw", least)


def test_good_mesh_is_not_refused():
    refuse_bad(Quality(10, 20, 0.06, 0.5, 0.1, 4, (0.0, 0.0, 0.0)), "screw", 0.05)


def bent(by):
    """Two tetrahedra on a common face; the edge (0, 1) of the first lies on a surface and is bent towards node 3."""
    corners = np.vstack([REGULAR, [-3.0, 3.0, -3.0]])
    cells = np.array([[0, 1, 2, 3], [0, 3, 2, 4]])
    x = [corners]
    number, rows = {}, []
    for cell in cells:
        row = list(cell)
        for i, j in quality.TET_EDGES:
            key = tuple(sorted((cell[i], cell[j])))
            if key not in number:
                number[key] = len(corners) + len(number)
                x.append(0.5 * (corners[key[0]] + corners[key[1]])[None])
            row.append(number[key])
        rows.append(row)
    points, cells = np.concatenate(x), np.array(rows)
    if scaled_jacobians(points, cells, "P2")[1] < 0.0:
        cells[1] = cells[1][[0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    middle = number[(0, 1)]
    points[middle] += by * (corners[[2, 3]].mean(axis=0) - points[middle])
    return points, cells, np.array([0, 1, middle])


def test_untangle_bends_inner_edges_along():
    points, cells, surface = bent(0.62)
    before = scaled_jacobians(points, cells, "P2")
    assert before.min() < 0.0
    after = untangle(points, cells, surface)
    assert scaled_jacobians(after, cells, "P2").min() > 0.02
    np.testing.assert_array_equal(after[surface], points[surface])
    np.testing.assert_array_equal(after[:5], points[:5])  # corners stay


def test_untangle_leaves_a_good_mesh_alone():
    points, cells, surface = bent(0.1)
    np.testing.assert_array_equal(untangle(points, cells, surface), points)


def test_straighten_moves_only_what_may_move():
    points, cells, surface = bent(0.9)
    found, moved = straighten(points, cells, np.array([], dtype=int))
    assert moved == 1
    np.testing.assert_allclose(found[surface[2]], points[:2].mean(axis=0), atol=1e-15)
    assert scaled_jacobians(found, cells, "P2").min() > 0.1
    kept, moved = straighten(points, cells, surface[2:])
    assert moved == 0
    np.testing.assert_array_equal(kept, points)


def test_deviation_is_the_largest_distance_from_the_circle():
    angle = np.linspace(0.3, 1.2, 9)
    x, z = 2e-3 + 3e-3 * np.cos(angle), -1e-3 + 3e-3 * np.sin(angle)
    assert arc_deviation(x, z, np.array([2e-3, -1e-3]), 3e-3) < 1e-18
    x[4] += 5e-6 * np.cos(angle[4])
    z[4] += 5e-6 * np.sin(angle[4])
    assert arc_deviation(x, z, np.array([2e-3, -1e-3]), 3e-3) == pytest.approx(5e-6, rel=1e-9)
    assert arc_deviation(x[:0], z[:0], np.array([2e-3, -1e-3]), 3e-3) == 0.0


def test_elements_across_a_semi_axis():
    even = np.linspace(-1.0, 1.0, 21)
    assert elements_across(even, 0.35) == pytest.approx(3.5)
    graded = np.array([-1.0, -0.4, -0.2, 0.0, 0.1, 0.2, 1.0])
    assert elements_across(graded, 0.2) == pytest.approx(1.5)  # one on the left, two on the right


@pytest.mark.parametrize(
    ("boundaries", "semi", "match"),
    [([0.0, 1.0], 0.5, "zero"), ([-1.0, 0.5, 0.2, 1.0], 0.5, "ascend"), ([-1.0, 1.0], 1.5, "zone larger")],
)
def test_senseless_zones_are_refused(boundaries, semi, match):
    with pytest.raises(ValueError, match=match):
        elements_across(np.array(boundaries), semi)
