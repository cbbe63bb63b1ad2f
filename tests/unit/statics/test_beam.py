"""Timoshenko beam: two forms of the element against each other, its shape functions, closed forms, partitions."""

import numpy as np
import pytest
from scipy.linalg import qr
from tests.helpers import STEEL, dense, relative, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi import jit
from rollbench.lowfi.as_source import element_stiffness
from rollbench.lowfi.statics.kernel import banded, beam, newton
from rollbench.lowfi.statics.kernel_types import BeamArrays
from rollbench.lowfi.statics.shape import motions_at, pivots, rigid_transport, shape_polynomials
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.section import beam_nodes, contact_stations, fixed_partition, tube_section

SECTION = tube_section(30e-3, 8e-3, STEEL)
STIFFNESSES = np.array([SECTION.EA, SECTION.EI, SECTION.GJ, SECTION.kGA])
LENGTHS = [1e-4, 5e-3, 40e-3, 1.0]
PARTITIONS = {
    "one element": [0.0, 0.4],
    "even": np.linspace(0.0, 0.4, 9),
    "ragged": [0.0, 1e-4, 0.03, 0.1, 0.1001, 0.39, 0.4],
}


def assembled(nodes):
    """Lower band of the free beam on ``nodes``."""
    band = np.zeros((6 * len(nodes), 12))
    for e, length in enumerate(np.diff(nodes)):
        beam.add_element(band, e, length, STIFFNESSES)
    return band


def cantilever(nodes, load):
    """Motions of all nodes, the first one held, under a load (6,) on the last one."""
    band = assembled(nodes)[6:]
    b = np.zeros(band.shape[0])
    b[-6:] = load
    assert banded.factor_band(band)
    banded.substitute_band(band, b)
    return b.reshape(-1, 6)


def interpolation(xi, length, order=0):
    return shape_polynomials(np.array([xi]), np.array([length]), SECTION, order)[0]


@pytest.mark.parametrize("length", LENGTHS)
def test_element_is_the_strain_energy_of_its_shape_functions(length):
    """K = integral of EA u_z'2 + GJ theta_z'2 + EI theta'2 + kappa G A (u' - theta)2 over the element, in the band too.

    d = q2 - T q1 carries what the stiffness matrix gives: f at node 2 and -T^T f at node 1.
    """
    points, weights = np.polynomial.legendre.leggauss(5)
    expected = np.zeros((12, 12))
    for x, w in zip(points, weights, strict=True):
        xi = (x + 1) / 2
        n, slope = interpolation(xi, length), interpolation(xi, length, 1) / length
        strains = slope[2], slope[5], slope[3], slope[4], slope[0] - n[4], slope[1] + n[3]
        kinds = SECTION.EA, SECTION.GJ, SECTION.EI, SECTION.EI, SECTION.kGA, SECTION.kGA
        expected += sum(0.5 * w * length * k * np.outer(b, b) for k, b in zip(kinds, strains, strict=True))
    found, band = element_stiffness(length, SECTION), dense(assembled([0.0, length]))
    size = np.sqrt(np.diag(found))  # every entry on its own scale
    assert np.abs((expected - found) / np.outer(size, size)).max() < 1e-11
    assert relative(band, found) < 1e-15
    assert np.abs((band - found) / np.outer(size, size)).max() < 1e-14
    rng, transport = np.random.default_rng(4), rigid_transport(length)
    for _ in range(5):
        q, f = rng.normal(size=12) * np.tile([length] * 3 + [1.0] * 3, 2), np.empty(6)
        beam.force_of(q[6:] - transport @ q[:6], beam.element_constants(length, STIFFNESSES), f)
        off = np.concatenate([-transport.T @ f, f]) - found @ q
        assert np.abs(off / (size * np.abs(size * q).max())).max() < 1e-13


@pytest.mark.parametrize("nodes", PARTITIONS.values(), ids=PARTITIONS)
def test_rigid_motion_strains_nothing(nodes):
    """Six rigid motions of the whole beam: no force beyond round-off of the stiffest element."""
    motions = np.stack([rigid_transport(z) for z in nodes]).reshape(-1, 6)
    k = dense(assembled(nodes))
    assert np.abs(k @ motions).max() < 1e-14 * np.abs(k).max()
    assert np.linalg.matrix_rank(k / np.sqrt(np.outer(np.diag(k), np.diag(k))), tol=1e-12) <= k.shape[0] - 6


def test_positions_of_a_rigid_beam():
    lengths, q, nothing = np.array([0.1, 0.25]), np.zeros((3, 6)), np.zeros((3, 6))
    constants = np.array([beam.element_constants(length, STIFFNESSES) for length in lengths])
    shaft = BeamArrays(lengths, nothing > 0.0, nothing, constants, np.zeros((18, 12)))
    q[0] = [1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3]
    assert newton.evaluate_beam(shaft, q, np.zeros((2, 6)), np.zeros((3, 6))) == (0.0, 0.0)
    assert q[2] == pytest.approx([1e-3 + 0.35 * 5e-3, 2e-3 - 0.35 * 4e-3, 3e-3, 4e-3, 5e-3, 6e-3], rel=1e-14)
    newton.evaluate_beam(shaft, q, np.array([[0, 0, 1e-6, 0, 0, 0], [7e-6, 0, 0, 0, 0, 0]]), np.zeros((3, 6)))
    assert q[2, :3] == pytest.approx([1e-3 + 0.35 * 5e-3 + 7e-6, 2e-3 - 0.35 * 4e-3, 3.001e-3], rel=1e-14)


@pytest.mark.parametrize("nodes", PARTITIONS.values(), ids=PARTITIONS)
def test_cantilever(nodes):
    """Tip: F L3/3EI + F L/(kappa G A), slope F L2/2EI; by a moment M L2/2EI and M L/EI; F L/EA and T L/GJ."""
    length, (fx, fy, fz, mx, my, mz) = 0.4, (100.0, -70.0, 500.0, 3.0, 5.0, 7.0)
    bend, shear = length / SECTION.EI, length / SECTION.kGA
    expected = [
        fx * (length**2 * bend / 3 + shear) + my * length * bend / 2,
        fy * (length**2 * bend / 3 + shear) - mx * length * bend / 2,
        fz * length / SECTION.EA,
        mx * bend - fy * length * bend / 2,
        my * bend + fx * length * bend / 2,
        mz * length / SECTION.GJ,
    ]
    tip = cantilever(nodes, [fx, fy, fz, mx, my, mz])[-1]
    assert tip == pytest.approx(expected, rel=1e-7 if len(nodes) == 7 else 1e-11)


def test_any_partition_gives_the_same_nodal_values():
    coarse, fine = [0.0, 0.1, 0.4], np.linspace(0.0, 0.4, 17)
    load = [100.0, -70.0, 500.0, 3.0, 5.0, 7.0]
    assert cantilever(fine, load)[[3, 15]] == pytest.approx(cantilever(coarse, load), rel=1e-9)


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("xi", [0.0, 0.3, 0.5, 0.9, 1.0])
def test_shape_functions_are_the_exact_interior(length, xi):
    """Interpolation equals the solution with a node put there (condensed), and the nodal values at the ends."""
    n = interpolation(xi, length)
    if xi in (0.0, 1.0):
        expected = np.hstack([np.eye(6) * (1 - xi), np.eye(6) * xi])
    else:
        k = dense(assembled([0.0, xi * length, length]))
        outer = np.r_[0:6, 12:18]
        expected = -np.linalg.solve(k[6:12, 6:12], k[6:12][:, outer])
    size = np.array([length] * 3 + [1.0] * 3)
    assert np.abs((n - expected) / size[:, None] * np.tile(size, 2)).max() < 1e-10


@pytest.mark.parametrize("order", [1, 2])
def test_shape_derivatives(order):
    length, h = 5e-3, 1e-4
    for xi in (0.1, 0.5, 0.8):
        low, high = (interpolation(xi + x, length, order - 1) for x in (-h, h))
        found = interpolation(xi, length, order)
        assert relative(found, (high - low) / (2 * h)) < 1e-7  # cubic polynomials: the difference errs by h2 u'''/6


@pytest.mark.parametrize("order", [0, 1, 2])
def test_shape_functions_for_many_points(order):
    rng = np.random.default_rng(0)
    xi, length = rng.uniform(size=8), rng.uniform(1e-3, 0.1, 8)
    found = shape_polynomials(xi, length, SECTION, order)
    for i in range(8):
        assert relative(found[i], interpolation(xi[i], length[i], order)) < 1e-14


def test_motion_beyond_the_ends_is_rigid():
    nodes, q = np.array([0.1, 0.2, 0.4]), np.arange(1.0, 19.0).reshape(3, 6)
    for z, end in ((0.05, 0), (0.45, 2)):
        found = motions_at(np.array([z]), nodes, SECTION, q)[0]
        assert found == pytest.approx(rigid_transport(z - nodes[end]) @ q[end], rel=1e-14)
    assert motions_at(np.array([0.2]), nodes, SECTION, q)[0] == pytest.approx(q[1], rel=1e-14)


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
def test_banded_solver(engine):
    """Both engines against a dense solution of a random band, scaled like the beam; round-off of the dense solution is
    up to 1.4e-11 of one of its values, by the processor."""
    kernels = jit.kernels(jit.STATICS, compiled=engine == "compiled").banded
    rng = np.random.default_rng(1)
    for n, width in ((1, 1), (5, 5), (12, 12), (60, 12), (60, 24)):
        band = rng.uniform(-1.0, 1.0, (n, width))
        band[:, 0] = 2.0 * width
        for j in range(n):
            band[j, n - j :] = 0.0
        scale = 10.0 ** rng.uniform(-3, 3, n)
        for j in range(n):
            m = min(width, n - j)
            band[j, :m] *= scale[j] * scale[j : j + m]
        b = rng.normal(size=n)
        expected = np.linalg.solve(dense(band) / np.outer(scale, scale), b / scale) / scale
        assert kernels.factor_band(band)
        kernels.substitute_band(band, b)
        assert b * scale == pytest.approx(expected * scale, rel=3e-11, abs=1e-13 * np.abs(expected * scale).max())


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
def test_banded_solver_refuses_an_indefinite_matrix(engine):
    kernels = jit.kernels(jit.STATICS, compiled=engine == "compiled").newton
    assert not kernels.factor_band(np.array([[1.0, 2.0], [1.0, 0.0]]))
    assert not kernels.factor_band(np.array([[-1.0, 0.0], [-1.0, 0.0]]))  # a positive determinant


def test_the_sources_partition_has_27_elements():
    """Table 2.2: 12 + 3 + 12, 15 mm inside the nut."""
    scene = with_ingredients(catalogue.scene("lin-case1"), partition="source")
    nodes = fixed_partition(scene)
    assert nodes.size - 1 == 27
    assert nodes[[0, -1]] == pytest.approx([0.0, 0.8])
    assert nodes[12:16] == pytest.approx([0.3775, 0.3925, 0.4075, 0.4225])
    assert np.diff(nodes)[[*range(12), *range(15, 27)]] == pytest.approx(0.3775 / 12)


def test_nodal_partition_has_a_node_at_every_contact_support_and_load_and_no_idle_end():
    at_ends, scene = catalogue.scene("lin-case3-offset"), catalogue.scene("lin-case1")
    (full, first), (short, stations) = ((s, contact_stations(s, ball_layout(s))) for s in (at_ends, scene))
    nodes, _ = beam_nodes(full, first)
    assert np.abs(nodes[None, :] - first.ravel()[:, None]).min(axis=1).max() < 1e-5
    assert nodes[[0, -1]] == pytest.approx([0.0, 0.8])
    (nodes, left_out), (everything, none) = (beam_nodes(short, stations, everything=e) for e in (False, True))
    assert (left_out, none) == (1, 0)
    assert everything.size == nodes.size + 1
    assert nodes[-1] == pytest.approx(stations.max())


def test_pivots_are_those_of_qr_with_column_pivoting():
    rng = np.random.default_rng(5)
    for rows in (rng.normal(size=(3, 6)), np.outer([1.0, 2.0], rng.normal(size=6)), np.zeros((2, 4))):
        _, r, order = qr(rows, pivoting=True)
        rank = int((np.abs(np.diag(r)) > 1e-12).sum())
        assert pivots(rows)[:rank] == order[:rank].tolist()
        assert rank or not pivots(rows)
