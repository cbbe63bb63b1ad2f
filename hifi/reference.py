"""The 3D elastic-contact reference of a ball screw or bearing: the contact of all balls of a prepared geometry.

Contact is unilateral and frictionless on matching nodes of ball and groove, the balls' rigid motions free. Gaps are exact
distances from the ball's centre; directions and gaps follow the motion of ball and groove to convergence.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import lsqr

from hifi.balls import solve_balls
from hifi.compliance import Compliance, coupled
from hifi.contact import ContactResult
from hifi.setup import Setup, rotation
from meshes.errors import Specimen, specimen
from meshes.helix import groove_radii, nominal_groove_centres
from meshes.parts import Scene
from meshes.surface import groove_profile

Array = NDArray[np.float64]

#: Change of the relative motions [m] below which directions and gaps count as settled.
SETTLED = 2e-9


@dataclass(frozen=True)
class ReferenceResult:
    """Loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [rad], ball motions ``(n, 3)`` [m], screw's rigid motions, contact
    record, residuals, unknowns (of the equivalent monolithic mesh), seconds by stage, status."""

    status: str
    load: Array
    contact_angle: Array
    ball_motion: Array
    screw_motion: Array
    contact: ContactResult
    balance: float
    along_groove: float
    unknowns: int
    seconds: dict[str, float]
    updates: int


def compliance_of(setup: Setup) -> Compliance:
    """Compliance of all contact nodes, ball after ball, side after side."""
    sides = setup.sides
    count = setup.layout.z.size
    block = setup.ball.copy()
    sizes = [len(setup.patches[s].groove.A) for s in sides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    for k, s in enumerate(sides):
        part = slice(starts[k], starts[k + 1])
        block[part, part] += setup.patches[s].groove.A
    screw_modes = [setup.screw.modes.get(s) for s in sides]
    nut_modes = [setup.nut.modes.get(s) if setup.nut else None for s in sides]
    per_ball = [m for m in screw_modes if m is not None]
    r_screw = sum(m.shape[1] for m in per_ball)
    r_nut = sum(m.shape[1] for m in nut_modes if m is not None)
    total_screw = setup.screw.G.shape[0]
    total = total_screw + (setup.nut.G.shape[0] if setup.nut else 0)
    G = np.zeros((total, total))
    G[:total_screw, :total_screw] = setup.screw.G
    if setup.nut:
        G[total_screw:, total_screw:] = setup.nut.G
    modes, columns = [], []
    for i in range(count):
        V = np.zeros((starts[-1], r_screw + r_nut))
        cols = np.concatenate([i * r_screw + np.arange(r_screw), total_screw + i * r_nut + np.arange(r_nut)])
        c_screw, c_nut = 0, r_screw
        for k, _s in enumerate(sides):
            part = slice(starts[k], starts[k + 1])
            own, other = screw_modes[k], nut_modes[k]
            if own is not None:
                V[part, c_screw : c_screw + own.shape[1]] = own
                c_screw += own.shape[1]
            if other is not None:
                V[part, c_nut : c_nut + other.shape[1]] = other
                c_nut += other.shape[1]
        modes.append(V)
        columns.append(cols.astype(np.int64))
    return coupled([block] * count, modes, G, columns)


def solve_reference(setup: Setup, scene: Scene, *, updates: int = 6, member: int = 0) -> ReferenceResult:
    """Loads of a load case or error pattern of a prepared geometry.

    updates: how often directions and gaps follow the motion at most (0: frozen at the nominal state).
    """
    begin = perf_counter()
    drawn = specimen(scene, setup.layout, member)
    sides, count = setup.sides, setup.layout.z.size
    C = compliance_of(setup)
    sizes = [len(setup.patches[s].groove.A) for s in sides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    n = int(starts[-1])
    m = setup.map
    centre = np.array([m.R, 0.0, 0.0])
    nominal = np.concatenate([setup.patches[s].groove.points - centre for s in sides])
    errors = _groove_errors(setup, drawn)
    total_screw = setup.screw.G.shape[0]
    case = (scene.supports, scene.loads)
    if case not in setup.cases:
        raise ValueError(f"{scene.name} has loads or supports that were not prepared")
    loads_modal = setup.screw.loads[:, setup.cases.index(case)]
    load_motion = _modal_motion(C, np.concatenate([loads_modal, np.zeros(C.coupling.shape[0] - total_screw)]))
    shift = np.zeros((count, n, 3))
    motions = setup.screw_pins
    state: tuple[Array, Array] | None = None
    done = 0
    directions_ = np.broadcast_to(nominal / np.linalg.norm(nominal, axis=1)[:, None], (count, n, 3))
    while True:
        arms = nominal[None] + errors - shift
        length = np.linalg.norm(arms, axis=2)
        directions_ = arms / length[..., None]
        gap = length - drawn.ball_radius[:, None] + np.einsum("ink,ink->in", directions_, shift)
        N = _directions_matrix(setup, directions_, motions)
        f = np.concatenate([np.zeros(3 * count), _rigid_loads(scene, motions)])
        rest = gap.ravel() + load_motion
        if state is None:
            state = first_guess(setup, scene, C, rest, N, gap)
        result, amplitude = solve_balls(C, rest, N, f, start=state)
        state = (amplitude, result.motions)
        new = _relative_motion(setup, result, C, directions_, motions, loads_modal)
        change = float(np.abs(new - shift).max())
        shift = new
        if change < SETTLED or done == updates or not result.converged:
            break
        done += 1
    forces = result.forces.reshape(count, n)
    vectors = forces[..., None] * directions_
    load = np.zeros((count, 4))
    angle = np.full((count, 4), np.nan)
    for k, s in enumerate(sides):
        part = slice(starts[k], starts[k + 1])
        total = vectors[:, part].sum(axis=1)
        load[:, s] = np.linalg.norm(total, axis=1)
        unit = total / np.maximum(load[:, s], 1e-300)[:, None]
        z3 = np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
        sx, sz = m.signs[s]
        angle[:, s] = np.where(load[:, s] > 0, np.arctan2(sz * (unit @ z3), sx * unit[:, 0]), np.nan)
    net = vectors.sum(axis=1)
    largest = max(float(load.max()), 1e-300)
    y3 = np.array([0.0, np.cos(m.alpha), np.sin(m.alpha)])
    seconds = {**setup.seconds, "contact": perf_counter() - begin}
    status = result.status
    if status == "converged" and _at_rim(setup, forces):
        status = "the contact reaches the rim of its patch: the expected semi-axes are too small"
    return ReferenceResult(
        status, load, angle, result.motions[: 3 * count].reshape(count, 3), result.motions[3 * count :], result,
        float(np.abs(net).max()) / largest, float(np.abs(net @ y3).max()) / largest, setup.unknowns, seconds, done,
    )  # fmt: skip


def _at_rim(setup: Setup, forces: Array) -> bool:
    """Whether any ball presses on the outermost nodes of a contact zone."""
    start = 0
    for s in setup.sides:
        na, nb = setup.patches[s].groove.shape
        grid = forces[:, start : start + na * nb].reshape(-1, na, nb)
        start += na * nb
        if (grid[:, [0, -1]] > 0.0).any() or (grid[:, :, [0, -1]] > 0.0).any():
            return True
    return False


def first_guess(
    setup: Setup, scene: Scene, C: Compliance, rest: Array, N: sp.csr_matrix, gap: Array
) -> tuple[Array, Array]:
    """Start of the contact iteration: equal loads, spread over the nearest nodes, and motions that close the gaps there."""
    count, n = gap.shape
    m = setup.map
    total = sum(float(np.linalg.norm(load.force)) + float(np.linalg.norm(load.moment)) / m.R for load in scene.loads)
    share = max(total / (count * np.sin(m.beta) * np.cos(m.alpha)), 1.0)
    sizes = [len(setup.patches[s].groove.A) for s in setup.sides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    guess = np.zeros((count, n))
    for k, s in enumerate(setup.sides):
        part = slice(starts[k], starts[k + 1])
        areas = setup.patches[s].groove.areas
        own = gap[:, part] - gap[:, part].min(axis=1, keepdims=True)
        reach = np.partition(own, sizes[k] // 3, axis=1)[:, sizes[k] // 3, None]
        weight = np.sqrt(np.maximum(1.0 - own / reach, 0.0)) * areas
        guess[:, part] = weight / weight.sum(axis=1, keepdims=True) * share
    lam = guess.ravel()
    w = np.zeros(C.coupling.shape[0])
    for i, (V, c) in enumerate(zip(C.modes, C.columns, strict=True)):
        np.add.at(w, c, V.T @ lam[i * n : (i + 1) * n])
    loaded = lam > 0.0
    scale = np.sqrt(lam[loaded])
    y = lsqr(sp.diags(scale) @ N[loaded], scale * (rest + C.apply(lam))[loaded], atol=1e-14, btol=1e-14, iter_lim=3000)[0]
    return w, np.asarray(y)


def _groove_errors(setup: Setup, drawn: Specimen) -> Array:
    """Displacement of each groove by its geometric errors at every contact node, ``(balls, n, 3)`` in the ball's frame."""
    m = setup.map
    x3, z3 = np.array([1.0, 0.0, 0.0]), np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    rows = []
    nominal_centres, radii = nominal_groove_centres(setup.scene), groove_radii(setup.scene)
    for s in setup.sides:
        points = setup.patches[s].groove.points
        offset = drawn.centre[:, s] - nominal_centres[s]
        shift = offset[:, :1, None] * x3 + offset[:, 1:, None] * z3
        local = points - np.array([m.R, 0.0, 0.0])
        gamma, _ = m.polar(s, local @ x3, local @ z3)
        inward = radii[s] - groove_profile(gamma, drawn.radius[s], drawn.profile[s])[0]
        sx, sz = m.signs[s]
        outward = sx * np.cos(gamma)[:, None] * x3 + sz * np.sin(gamma)[:, None] * z3
        rows.append(shift - (inward[:, None] * outward)[None])
    return np.concatenate(rows, axis=1)


def _modal_motion(C: Compliance, z: Array) -> Array:
    """Motion of every contact node along its normal by modal motions z ``(r,)``."""
    return np.concatenate([V @ z[c] for V, c in zip(C.modes, C.columns, strict=True)])


def _directions_matrix(setup: Setup, directions_: Array, motions: Array) -> sp.csr_matrix:
    """N: gap closed by unit motions of each ball (3) and of the screw's unheld rigid motions."""
    count, n, _ = directions_.shape
    rows, cols, vals = [], [], []
    for i in range(count):
        rows.append(np.repeat(i * n + np.arange(n), 3))
        cols.append(np.tile(3 * i + np.arange(3), n))
        vals.append(directions_[i].ravel())
    if motions.shape[1]:
        screw = _screw_rows(setup, directions_)
        for k in range(motions.shape[1]):
            closing = -(screw @ motions[:, k])
            own = np.flatnonzero(closing)
            rows.append(own)
            cols.append(np.full(own.size, 3 * count + k))
            vals.append(closing[own])
    return sp.coo_matrix(
        (np.concatenate(vals), (np.concatenate(rows), np.concatenate(cols))), (count * n, 3 * count + motions.shape[1])
    ).tocsr()


def _screw_rows(setup: Setup, directions_: Array) -> Array:
    """Motion of the screw's contact nodes along their normals by its rigid motion about the first station, (c n, 6)."""
    count, n, _ = directions_.shape
    sizes = [len(setup.patches[s].groove.A) for s in setup.sides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    first = min([x.at for x in setup.scene.supports] + [x.at for x in setup.scene.loads] + [
        setup.scene.nut.position - setup.scene.nut.length])
    nodes = sorted({x.at for x in setup.scene.supports} | {x.at for x in setup.scene.loads})
    origin = nodes[0] if nodes else first
    out = np.zeros((count, n, 6))
    for k, s in enumerate(setup.sides):
        if s >= 2:
            continue
        part = slice(starts[k], starts[k + 1])
        local = setup.patches[s].groove.points
        for i in range(count):
            R = rotation(float(setup.layout.azimuth[i]))
            x = local @ R.T + np.array([0.0, 0.0, setup.layout.z[i] - origin])
            d = directions_[i, part] @ R.T
            out[i, part, :3] = d
            out[i, part, 3:] = np.cross(x, d)
    return out.reshape(count * n, 6)


def _rigid_loads(scene: Scene, motions: Array) -> Array:
    """Work of the loads on the screw's unheld rigid motions about its first station."""
    nodes = sorted({x.at for x in scene.supports} | {x.at for x in scene.loads})
    wrench = np.zeros(6)
    for load in scene.loads:
        f, mo = np.array(load.force), np.array(load.moment)
        wrench[:3] += f
        wrench[3:] += mo + np.cross([0.0, 0.0, load.at - nodes[0]], f)
    return np.asarray(motions.T @ wrench)


def _relative_motion(
    setup: Setup, result: ContactResult, C: Compliance, directions_: Array, motions: Array, loads_modal: Array,
) -> Array:  # fmt: skip
    """Motion of each ball's centre relative to each of its grooves, ``(balls, n, 3)``, the same for a side's nodes.

    The groove's own motion is read along the normal from the body's modes and its rigid motion: what the ball's centre
    moves beyond the groove, in the section plane.
    """
    count, n, _ = directions_.shape
    sizes = [len(setup.patches[s].groove.A) for s in setup.sides]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    y = result.motions[: 3 * count].reshape(count, 3)
    amplitude = np.zeros(C.coupling.shape[0])
    for i, (V, c) in enumerate(zip(C.modes, C.columns, strict=True)):
        np.add.at(amplitude, c, V.T @ result.forces[i * n : (i + 1) * n])
    z = C.coupling @ amplitude
    z[: setup.screw.G.shape[0]] += loads_modal
    along = _modal_motion(C, z).reshape(count, n)
    if motions.shape[1]:
        along = along + (_screw_rows(setup, directions_) @ motions @ result.motions[3 * count :]).reshape(count, n)
    shift = np.zeros((count, n, 3))
    for k, _s in enumerate(setup.sides):
        part = slice(starts[k], starts[k + 1])
        for i in range(count):
            d = directions_[i, part]
            v = np.linalg.lstsq(d, along[i, part], rcond=1e-6)[0]
            shift[i, part] = y[i] - v
    y3 = np.array([0.0, np.cos(setup.map.alpha), np.sin(setup.map.alpha)])
    shift -= (shift @ y3)[..., None] * y3  # ball and groove are invariant along the track
    return shift
