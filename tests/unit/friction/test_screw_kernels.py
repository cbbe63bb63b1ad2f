"""Kernels of ball screws: both engines, derivatives by differences, banded elimination, cached machine code."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence.source_cases import inferred, plain, table_3_6
from rollbench.lowfi.friction.contact.kernel import band
from rollbench.lowfi.friction.screw.chain import Chain, Search, solve_chain, solve_joint, system_of
from rollbench.lowfi.friction.screw.groove import ScrewGroove, groove_arrays
from rollbench.lowfi.friction.screw.kernel import balance, joint
from rollbench.lowfi.friction.screw.kernel_types import JointMatrix, Place
from rollbench.lowfi.friction.screw.motion import hold_screw, settle_load
from rollbench.lowfi.jit import SCREW, kernels


@pytest.fixture
def rng() -> np.random.Generator:
    """The same draws in whatever order tests run."""
    return np.random.default_rng(8)


TWO = np.radians(2.0)
SLACK = np.array([0.0, np.inf])


@pytest.mark.parametrize("free", ["", "z", "rz"])
@pytest.mark.parametrize("oversize", [-3e-6, 0.0, 1.7e-6])
def test_both_engines_settle_alike(free: str, oversize: float) -> None:
    pair = replace(inferred(TWO), oversize=oversize, free=free, force=(3.0, 50.0)[2 - len(free) :])
    push = np.zeros((2, 2)) if oversize < 0.0 else np.array([[1.0, -2.0], [0.5, 3.0]])
    cell = replace(pair.cell(), push=push)
    fast, slow = settle_load(cell), settle_load(cell, fast=False)
    assert fast.converged
    assert slow.converged
    assert fast.steps == slow.steps
    assert fast.force == pytest.approx(slow.force, rel=1e-12, abs=1e-15)
    assert fast.angle == pytest.approx(slow.angle, rel=1e-13)


@pytest.mark.parametrize("make", [plain, inferred])
def test_both_engines_move_alike(make) -> None:
    """Motion, ball-to-ball force and losses, from the same loads."""
    cell = make(TWO).cell()
    load = settle_load(cell)
    chain = Chain(cell.groove, load.force, cell.groove.normals(load.angle), SLACK)
    fast, slow = solve_chain(chain), solve_chain(chain, fast=False)
    assert fast.converged
    assert slow.converged
    assert fast.steps == slow.steps
    assert fast.q == pytest.approx(slow.q, rel=1e-9)
    assert fast.ball_force == pytest.approx(slow.ball_force, rel=1e-9)
    assert fast.wrench == pytest.approx(slow.wrench, rel=1e-9, abs=1e-9)
    assert fast.ball_push == pytest.approx(slow.ball_push, rel=1e-9, abs=1e-12)
    assert fast.loss == pytest.approx(slow.loss, rel=1e-11)


def test_both_engines_solve_the_joint_system_alike() -> None:
    cell = plain(TWO).cell()
    load = settle_load(cell)
    held = hold_screw(cell, load)
    fast, slow = (solve_joint(held, SLACK, (load.ball, np.zeros(0)), fast=f) for f in (True, False))
    assert fast.done
    assert slow.done
    assert fast.push == pytest.approx(slow.push, rel=1e-9, abs=1e-12)
    assert fast.ball == pytest.approx(slow.ball, rel=1e-9, abs=1e-15)
    assert fast.ball_force == pytest.approx(slow.ball_force, rel=1e-8)


@pytest.mark.parametrize("screw", [table_3_6(), table_3_6(nut_speed=5.0, screw_speed=-1.5), table_3_6(lead=0.0)])
def test_maps_of_the_kernels_are_those_of_the_groove(screw: ScrewGroove) -> None:
    """Scaled by speed over lever; the drive by the body's motion included."""
    angle, q = np.array([0.6, 0.8, 0.9, 0.7]), np.array([2.0, -3.0, 0.7, 8.0])
    normals = screw.normals(angle)
    maps, drives = screw.maps(normals)
    arrays, rows = groove_arrays(screw), np.empty((3, 4))
    levers = np.array([screw.radius, screw.ball_radius, screw.ball_radius, screw.ball_radius])
    x = q * levers / arrays.speed
    for i in range(4):
        balance.contact_map(arrays, normals[i, 0], normals[i, 2], rows)
        assert balance.seen(arrays, i, rows, x) == pytest.approx(drives[i] + maps[i] @ q, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(("n", "half", "columns"), [(1, 1, 1), (7, 2, 1), (40, 9, 1), (42, 12, 3)])
def test_banded_elimination(n: int, half: int, columns: int, rng: np.random.Generator) -> None:
    """Against a dense solution; the small diagonal makes rows change places."""
    full = rng.normal(size=(n, n))
    full[np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > half] = 0.0
    full[range(n), range(n)] *= 1e-9
    K, right = np.zeros((n, 3 * half + 1)), rng.normal(size=(n, columns))
    for i, j in np.argwhere(full != 0.0):
        K[i, half + j - i] = full[i, j]
    x = right.copy()
    band.solve_with_pivots(K, x, half)
    assert x == pytest.approx(np.linalg.solve(full, right), rel=1e-7, abs=1e-9)


def test_jacobian_of_the_joint_system_against_differences(rng: np.random.Generator) -> None:
    """Every entry: places, motions, force between the balls, screw; and the residual of both engines."""
    pair = replace(inferred(TWO), oversize=2.5e-6, free="rz", force=(3.0, 50.0))
    cell = pair.cell()
    load = settle_load(cell)
    s = Search(Chain(pair.groove, load.force, pair.groove.normals(load.angle), SLACK), False)
    system = system_of(cell, s)
    length = system.length

    def blank():
        return JointMatrix(
            np.empty(14),
            np.empty(2),
            np.empty((14, 3 * joint.HALF + 1)),
            np.empty((14, 2)),
            np.empty((2, 14)),
            np.empty((2, 2)),
        )

    def residual(z, fast=False):
        unknowns, m = z[:14].reshape(2, 7), blank()
        at = Place(unknowns[:, :2] * length, z[14:] * length, unknowns[:, 2:6].copy(), unknowns[:, 6].copy())
        kernels(SCREW, compiled=fast).assemble(system, at, 0.7, 1e-2, 0, m)
        return np.append(m.side, m.side_screw), m

    x = s.alone() * (1.0 + 0.1 * rng.normal(size=(2, 4)))
    unknowns = np.column_stack([load.ball / length + 0.1 * rng.normal(size=(2, 2)), x, rng.uniform(0.1, 0.3, 2)])
    z, h = np.append(unknowns.ravel(), load.inner / length), 1e-6
    value, (_, _, K, columns, lines, corner) = residual(z)
    full = np.zeros((16, 16))
    for i, j in np.ndindex(14, 14):
        full[i, j] = K[i, joint.HALF + j - i] if abs(j - i) <= joint.HALF else 0.0
    full[:14, 14:], full[14:, :14], full[14:, 14:] = columns, lines, corner
    found = np.array([(residual(z + h * e)[0] - residual(z - h * e)[0]) / (2.0 * h) for e in np.eye(16)]).T
    found[:7, 13] = 0.0  # the force of the last ball on the first, which do not touch
    assert full == pytest.approx(found, rel=1e-6, abs=1e-6)
    assert residual(z, fast=True)[0] == pytest.approx(value, rel=1e-11, abs=1e-13)
