"""The bodies' soft modes: conjugate gradients against the whole matrix; the same solution with and without them."""

import numpy as np
import pytest
from tests.helpers import relative, small_screw

from rollbench.comparison.scenes import catalogue
from rollbench.lowfi import jit
from rollbench.lowfi.compliance import modes as compliance_modes
from rollbench.lowfi.compliance.modes import SOFT, soft_modes
from rollbench.lowfi.statics import elastic_system as model
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.kernel import elastic as kernels
from rollbench.lowfi.statics.kernel import modes
from rollbench.lowfi.statics.records import Bodies, Factors


def body(rng, n, soft=(3000.0, 40.0, 2.0)):
    """Compliance of a body with a few soft modes and a stiff rest."""
    Q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    values = np.append(soft, rng.uniform(0.001, 0.2, n - len(soft)))
    G = (Q * values) @ Q.T
    return 0.5 * (G + G.T)


def system(d, free, count=21, stiff=1.0, seed=3):
    """Bodies, rows and right-hand sides at random, and S as one matrix."""
    rng = np.random.default_rng(seed)
    if d == 2:
        G, second = body(rng, 2 * count), np.zeros((0, 0))
        whole, width = G, 2
    else:
        G, second, width = body(rng, 4 * count), body(rng, 4 * count), 6
        whole = np.zeros((count, 8, count, 8))
        whole[:, :4, :, :4] = G.reshape(count, 4, count, 4)
        whole[:, 4:, :, 4:] = second.reshape(count, 4, count, 4)
        whole = whole.reshape(8 * count, 8 * count)
    R = rng.normal(size=(count, d, free))
    counts = rng.integers(0, width + 1, count)
    starts = np.append(0, np.cumsum(counts)[:-1])
    S = rng.normal(size=(count, width, d)) * np.sqrt(stiff)
    flat = np.zeros((counts.sum(), count, d))
    for i in range(count):
        flat[starts[i] : starts[i] + counts[i], i] = S[i, : counts[i]]
    U = [soft_modes(x, 1.0) for x in (G, second)]
    bodies = Bodies(G, second, R, np.zeros((count, d)), np.zeros(free), *U)
    return bodies, S, counts, starts, flat.reshape(counts.sum(), -1), whole, rng


def answer(whole, rows, R, hold, b, target):
    """The same equations by numpy."""
    SR = rows @ R.reshape(whole.shape[0], -1)
    k = SR.shape[1]
    K = np.block([[np.eye(len(rows)) + rows @ whole @ rows.T, -SR], [SR.T, hold * np.eye(k)]])
    x = np.linalg.solve(K, np.append(b, target))
    return x[: len(rows)], x[len(rows) :]


def iterate(found, target, hold, wanted, b):
    """Conjugate gradients on such a system."""
    bodies, S, counts, starts, rows, _, _ = found
    r = bodies.soft_first.shape[1] + bodies.soft_second.shape[1]
    W, C = np.empty((len(rows), r)), np.empty((r, r))
    assert modes.soft_factor((bodies.soft_first, bodies.soft_second), S, counts, starts, W, C)
    u, a = b.copy(), np.zeros(target.size)
    steps = modes.gradients(bodies, S, counts, starts, (W, C), target, hold, wanted, u, a)
    return u, a, steps


@pytest.mark.parametrize("hold", [0.0, 0.7])
@pytest.mark.parametrize("free", [0, 1, 3])
@pytest.mark.parametrize("d", [2, 8])
def test_conjugate_gradients_solve_the_bordered_equations(d, free, hold):
    found = system(d, free)
    bodies, rows, whole, rng = found[0], found[4], found[5], found[6]
    b, target = rng.normal(size=len(rows)), rng.normal(size=free)
    u, a, steps = iterate(found, target, hold, 1e-9, b)
    right_u, right_a = answer(whole, rows, bodies.R, hold, b, target)
    assert 1 <= steps <= 30
    assert relative(u, right_u) < 1e-8
    assert free == 0 or relative(a, right_a) < 1e-7


def test_fewer_steps_for_less_accuracy():
    found = system(2, 1)
    b, target = found[6].normal(size=len(found[4])), np.ones(1)
    steps = [iterate(found, target, 0.0, wanted, b)[2] for wanted in (1e-1, 1e-4, 1e-8)]
    assert steps[0] < steps[1] < steps[2]


def test_one_step_where_all_modes_are_soft(monkeypatch):
    monkeypatch.setattr(compliance_modes, "SOFT", 1e-6)
    found = system(2, 1)
    b, target = found[6].normal(size=len(found[4])), np.ones(1)
    assert iterate(found, target, 0.0, 1e-9, b)[2] == 0


def test_soft_modes_are_the_part_of_the_body_above_the_limit():
    G = body(np.random.default_rng(1), 20, (5.0, 0.5))
    U = soft_modes(G, 1.0)
    assert U.shape == (20, 2)
    assert relative(np.sort(np.linalg.eigvalsh(U.T @ U)), np.array([0.5, 5.0])) < 1e-12
    assert np.linalg.eigvalsh(G - U @ U.T).max() < SOFT


def test_of_large_bodies_only_the_modes_wanted_are_sought(monkeypatch):
    """Soft and negative modes against all eigenvalues, where more are soft, or negative, than are looked for at first."""
    monkeypatch.setattr(compliance_modes, "WHOLE", 100)
    monkeypatch.setattr(compliance_modes, "FEW", 4)
    Q = np.linalg.qr(np.random.default_rng(3).normal(size=(600, 600)))[0]
    values = np.concatenate([np.geomspace(1e3, 0.5, 30), np.geomspace(0.2, 1e-3, 566), -1e-3 * np.arange(1, 5)])
    U = soft_modes((Q * values) @ Q.T, 1.0)
    assert U.shape == (600, 30)
    assert relative(U @ U.T, (Q[:, :30] * values[:30]) @ Q[:, :30].T) < 1e-5
    found, least = compliance_modes.negative_part((Q * values) @ Q.T)
    assert relative(found, (Q[:, -4:] * values[-4:]) @ Q[:, -4:].T) < 1e-8
    assert least == pytest.approx(-4e-3, rel=1e-9)


@pytest.mark.parametrize("d", [2, 8])
def test_contacts_too_stiff_for_the_modes_are_factored_whole(d):
    """Where rows are so stiff that conjugate gradients give up, the whole matrix answers."""
    found = system(d, 1, count=60 if d == 2 else 25, stiff=1e9)
    bodies, S, counts, starts, rows, whole, rng = found
    b, target = rng.normal(size=len(rows)), rng.normal(size=1)
    assert iterate(found, target, 0.0, 1e-12, b)[2] == -1
    r = bodies.soft_first.shape[1] + bodies.soft_second.shape[1]
    factors = Factors(np.empty(0), np.empty((len(rows), r)), np.empty((r, r)))
    u, a = b.copy(), np.zeros(1)
    assert kernels.solve_rows(bodies, S, counts, starts, factors, True, target, 0.0, 1e-12, u, a)
    SR = rows @ bodies.R.reshape(whole.shape[0], -1)
    left = u + rows @ (whole @ (rows.T @ u)) - SR @ a - b
    assert np.abs(left).max() < 1e-4 * np.abs(SR * a).max()
    assert np.abs(SR.T @ u - target).max() < 1e-6 * np.abs(target).max()


SCENES = {
    "lin-case1": lambda: catalogue.scene("lin-case1"),
    "lin-case3-offset": lambda: catalogue.scene("lin-case3-offset"),
    "lin-combined": lambda: catalogue.scene("lin-combined"),
    "not held across": lambda: small_screw(
        12, 2.5, oversize=3e-6, force=(50.0, -80.0, 900.0), fixed=(("uz", 0.0), ("rz", 0.0)), load_at=0.0
    ),
}


@pytest.mark.parametrize("case", SCENES)
@pytest.mark.parametrize("everything", [False, True])
def test_modes_change_nothing_but_the_way(case, everything, monkeypatch):
    scene = SCENES[case]()
    found = []
    for least in (2, 10**9):
        monkeypatch.setattr(model, "MODES_FROM", least)
        found.append(solve_elastic(scene, everything=everything))
    assert found[0].converged
    assert found[1].converged
    assert relative(found[0].load, found[1].load) < 1e-9
    assert found[0].solver.iterations <= 1.5 * found[1].solver.iterations + 2


def test_engines_agree_with_modes():
    scene = catalogue.scene("lin-case1")
    found = [solve_elastic(scene, engine=engine) for engine in ("interpreted", "compiled")]
    assert relative(found[0].load, found[1].load) < 1e-11
    assert scene.ball_count >= model.MODES_FROM
    assert jit.is_compiled(jit.kernels(jit.STATICS, compiled=True).solve_forces.__module__)


def test_a_large_compliance_that_is_not_finite_is_refused() -> None:
    """A shift that makes it positive would be sought for ever."""
    G = np.eye(compliance_modes.WHOLE + 1)
    G[3, 4] = G[4, 3] = np.nan
    with pytest.raises(ValueError, match="infs or NaNs"):
        compliance_modes.negative_part(G)
