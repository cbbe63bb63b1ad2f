"""Timoshenko beam: two forms of the element against each other, its shape functions, closed forms, partitions."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.helpers import STEEL, dense

from rollbench.lowfi.statics import beam
from rollbench.lowfi.statics.shaft import build_shaft
from rollbench.lowfi.statics.shape import beam_shape_functions
from rollbench.meshes.section import tube_section

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
    lengths = np.diff(nodes)
    return beam.beam_stiffness_band(lengths, np.tile(STIFFNESSES[:, None], lengths.size))


def cantilever(nodes, load):
    """Motions of all nodes, the first one held, under a load (6,) on the last one."""
    band = assembled(nodes)[6:]
    b = np.zeros(band.shape[0])
    b[-6:] = load
    beam.substitute(beam.factor_band(band), b)
    return b.reshape(-1, 6)


def interpolation(xi, length, order=0):
    return beam_shape_functions(np.array([xi]), np.array([length]), SECTION, order)[0]


@pytest.mark.parametrize("nodes", [*PARTITIONS.values(), np.linspace(0.0, 0.4, 401)], ids=[*PARTITIONS, "many"])
def test_cantilever(nodes):
    """Tip: F L3/3EI + F L/(kappa G A), slope F L2/2EI; by a moment M L2/2EI and M L/EI; F L/EA and T L/GJ."""
    length, load = 0.4, (100.0, -70.0, 500.0, 3.0, 5.0, 7.0)
    fx, fy, fz, mx, my, mz = load
    bend, shear = length / SECTION.EI, length / SECTION.kGA
    expected = [
        fx * (length**2 * bend / 3 + shear) + my * length * bend / 2,
        fy * (length**2 * bend / 3 + shear) - mx * length * bend / 2,
        fz * length / SECTION.EA,
        mx * bend - fy * length * bend / 2,
        my * bend + fx * length * bend / 2,
        mz * length / SECTION.GJ,
    ]
    tip = cantilever(nodes, load)[-1]
    assert tip == pytest.approx(expected, rel=1e-11 if len(nodes) in (2, 9) else 1e-7)


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


@pytest.mark.parametrize("short", [1e-2, 1e-3, 5e-5])
def test_short_elements_cost_a_long_shaft_no_digits(short):
    """A cantilever of 0.8 m in closed form; the stiffness matrix alone loses seven digits to the shortest elements."""
    nodes = np.array([0.0, 0.3, 0.3 + short, 0.3 + 2.0 * short, 0.8])
    fixed = np.zeros((5, 6), dtype=bool)
    fixed[0] = True
    shaft = {
        "nodes": nodes,
        "fixed": fixed,
        "load": np.zeros((5, 6)),
        "section": SECTION,
        "middle": 0.3,
        "moment_arm": 0.01,
    }
    loads = np.zeros((30, 1))
    loads[24] = 100.0
    end = build_shaft(SimpleNamespace(**shaft, element_sections=None, rigid_motion_basis=None)).motions_under_loads(loads)[
        24
    ]
    assert end == pytest.approx(100.0 * (0.8**3 / (3.0 * SECTION.EI) + 0.8 / SECTION.kGA), rel=5e-13, abs=0.0)
