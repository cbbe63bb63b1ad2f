"""The 3D elastic-contact reference of a ball screw or bearing: the contact of all balls of a prepared geometry.

Contact is unilateral and frictionless on matching grids of ball and groove, the balls' rigid motions free. Pressures are
hats on the grid (`hifi.pressures`), and what may not be negative is the mean of the gap over each hat. Gaps are exact
distances from the ball's centre; directions and gaps follow the motion of ball and groove to convergence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import block_diag
from threadpoolctl import threadpool_limits

from hifi.balls import State, solve_balls
from hifi.compliance import BallBlock, Compliance, coupled
from hifi.contact import ContactResult
from hifi.mounting import Mounted, beam_stretch, mount
from hifi.part_meshes import rotation
from hifi.pressures import mean_weights
from hifi.response import transport
from hifi.setup import Setup
from meshes.errors import Specimen, specimen
from meshes.helix import groove_radii, nominal_groove_centres
from meshes.parts import Scene
from meshes.surface import groove_profile

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Change of the relative motions [m] below which directions and gaps count as settled.
SETTLED = 2e-9
#: Weight there of what contacts still stand off along the track: 0.1 um turns a resultant by 4e-5 rad.
SLIDE = 0.02
AT_RIM = "a contact reaches the rim of its patch: the expected semi-axes are too small"
#: Times that smaller a change of what the grid's wave does to a gap must be: it closes the gap in full.
WAVE = 20.0
#: Rounds allowed to it where directions are frozen.
ROUNDS = 6
#: Ingredients of the reference that can be left out, to see what they change.
INGREDIENTS = ("elastic nut", "3D shaft", "finite ball", "patch coupling", "moving normals")


@dataclass(frozen=True)
class ReferenceResult:
    """Loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [rad], ball motions ``(n, 3)`` [m], centreline: stations ``(s,)`` [m]
    and motions ``(s, 6)``, contact record, residuals, unknowns (of the equivalent monolithic mesh), seconds by stage,
    status."""

    status: str
    load: Array
    contact_angle: Array
    ball_motion: Array
    stations: Array
    centreline: Array
    sides: tuple[int, ...]
    directions: Array
    contact: ContactResult
    balance: float
    along_groove: float
    screw_balance: float
    unknowns: int
    seconds: dict[str, float]
    updates: int


@dataclass(frozen=True)
class _Zones:
    """Contact nodes of one ball, side after side: sides, their slices, number."""

    sides: tuple[int, ...]
    parts: tuple[slice, ...]
    size: int


def _zones(setup: Setup, sides: tuple[int, ...]) -> _Zones:
    ends = np.cumsum([0] + [len(setup.patches[s].groove.A) for s in sides])
    return _Zones(sides, tuple(slice(int(a), int(b)) for a, b in pairwise(ends)), int(ends[-1]))


def compliance_of(
    setup: Setup, mounted: Mounted, sides: tuple[int, ...], leave_out: frozenset[str] = frozenset()
) -> Compliance:
    """Compliance of all contact nodes, ball after ball, side after side."""
    zones, count = _zones(setup, sides), setup.layout.z.size
    block = ball_block(setup, sides, rigid=bool(leave_out & {"finite ball", "patch coupling"}))
    G_nut = None if setup.nut is None else setup.nut.G
    if G_nut is not None and leave_out & {"elastic nut", "patch coupling"}:
        G_nut = local_only(G_nut, _mode_counts(setup, False))
    total_screw = mounted.G.shape[0]
    G = block_diag(mounted.G, G_nut) if G_nut is not None else mounted.G
    used: list[Index] = []
    modes, columns = [], []
    taken = 0
    for i in range(count):
        pieces, own = [], []
        for part, s in zip(zones.parts, sides, strict=True):
            body = setup.screw if s < 2 else setup.nut
            if body is None:
                continue
            k = body.modes[s].shape[1]
            V = np.zeros((zones.size, k))
            V[part] = body.modes[s]
            pieces.append(V)
            own.append((0 if s < 2 else total_screw) + _first(setup, s, i) + np.arange(k))
        V = np.hstack(pieces)
        modes.append(V)
        columns.append(taken + np.arange(V.shape[1]))
        taken += V.shape[1]
        used += own
    pick = np.concatenate(used)
    return coupled([block] * count, modes, G[np.ix_(pick, pick)], columns)


def _first(setup: Setup, side: int, ball: int) -> int:
    """First row of a contact's modes in the coupling of its body."""
    counts = _mode_counts(setup, side < 2)
    own = [s for s in setup.sides if (s < 2) == (side < 2)]
    return ball * sum(counts) + sum(counts[: own.index(side)])


def _mode_counts(setup: Setup, screw: bool) -> list[int]:
    body = setup.screw if screw else setup.nut
    assert body is not None
    return [body.modes[s].shape[1] for s in setup.sides if (s < 2) == screw]


def _modal_rows(setup: Setup, sides: tuple[int, ...]) -> Index:
    """Rows of the screw's modes of the given sides, ball after ball, in the screw's own coupling."""
    rows = [
        _first(setup, s, i) + np.arange(setup.screw.modes[s].shape[1])
        for i in range(setup.layout.z.size)
        for s in sides
        if s < 2
    ]
    return np.concatenate(rows) if rows else np.zeros(0, dtype=np.int64)


def ball_block(setup: Setup, sides: tuple[int, ...], *, rigid: bool) -> BallBlock:
    """Compliance of a ball and its grooves' patches between pairs of ``sides``; rigid: ball rigid beyond its patches."""
    own = tuple(setup.patches[s].own for s in sides)
    ball = setup.ball
    if rigid:
        return BallBlock(own, tuple(np.zeros((len(a), 0)) for a in own), np.zeros((0, 0)))
    ends = np.cumsum([0] + [ball.modes[s].shape[1] for s in setup.sides])
    pick = np.concatenate([np.arange(ends[k], ends[k + 1]) for k, s in enumerate(setup.sides) if s in sides])
    return BallBlock(own, tuple(ball.modes[s] for s in sides), ball.G[np.ix_(pick, pick)])


def local_only(G: Array, counts: Sequence[int]) -> Array:
    """Coupling of a body that is rigid at large: every contact keeps the mean self response of its side, nothing else."""
    out = np.zeros_like(G)
    period = sum(counts)
    starts = np.concatenate([[0], np.cumsum(counts)])
    balls = G.shape[0] // period
    for a, b in pairwise(starts):
        mean = np.mean([G[i * period + a : i * period + b, i * period + a : i * period + b] for i in range(balls)], axis=0)
        for i in range(balls):
            out[i * period + a : i * period + b, i * period + a : i * period + b] = mean
    return out


def mounted_screw(setup: Setup, scene: Scene, leave_out: frozenset[str] = frozenset()) -> Mounted:
    """The screw under a scene's supports and loads; without the 3D shaft it is a beam with the same local response."""
    full = setup.screw.stretch
    if not leave_out & {"3D shaft", "patch coupling"} or full.rigid:
        return mount(full, scene, setup.section)
    counts = _mode_counts(setup, True)
    own = [s for s in setup.sides if s < 2]
    stations = np.repeat(setup.layout.z, len(own))
    beam = beam_stretch(setup.screw.rigid, stations, full, setup.section)
    m = full.modes
    F = beam.F.copy()
    F[:m, :m] += local_only(full.F[:m, :m] - beam.F[:m, :m], counts)
    return mount(replace(beam, F=F), scene, setup.section)


def solve_reference(
    setup: Setup,
    scene: Scene,
    *,
    updates: int = 6,
    sides: tuple[int, ...] | None = None,
    leave_out: frozenset[str] = frozenset(),
) -> ReferenceResult:
    """Loads of a load case or error pattern of a prepared geometry.

    updates: how often directions and gaps follow the motion at most (0: frozen at the nominal state); sides: those that
    may touch (all prepared ones if left out); leave_out: some of ``INGREDIENTS``. Raises ValueError for others.
    """
    if leave_out - set(INGREDIENTS):
        raise ValueError(f"unknown ingredients {sorted(leave_out - set(INGREDIENTS))}")
    with threadpool_limits(1):  # many small factors: the threads of two BLAS libraries only wait for one another
        return _solve(setup, scene, updates, setup.sides if sides is None else sides, leave_out)


def _solve(setup: Setup, scene: Scene, updates: int, sides: tuple[int, ...], leave_out: frozenset[str]) -> ReferenceResult:
    begin = perf_counter()
    sides = tuple(s for s in setup.sides if s in sides)
    moving = updates > 0 and "moving normals" not in leave_out
    drawn = specimen(scene, setup.layout)
    count, m, zones = setup.layout.z.size, setup.map, _zones(setup, sides)
    mounted = mounted_screw(setup, scene, leave_out)
    C = compliance_of(setup, mounted, sides, leave_out)
    n = zones.size
    nominal = np.concatenate([setup.patches[s].groove.points - np.array([m.R, 0.0, 0.0]) for s in sides])
    errors = _groove_errors(setup, drawn, sides)
    own_rows = _modal_rows(setup, sides)
    at_rest = _spread(setup, C, sides, mounted.loads[own_rows])
    load_motion = _modal_motion(C, at_rest)
    shift, level, slid = np.zeros((count, n, 3)), np.zeros((count, n)), np.zeros((count, n))
    along = _along_track(setup, sides)
    state: State | None = None
    done = 0
    while True:
        arms = nominal[None] + errors - shift
        length = np.linalg.norm(arms, axis=2)
        directions = arms / length[..., None]
        back = shift + slid[..., None] * along  # the solver's gaps lose it again
        gap = length - drawn.ball_radius[:, None] + np.einsum("ink,ink->in", directions, back)
        screw_rows = _over_hats(setup, zones, _screw_rows(setup, directions, zones, mounted.origin)).reshape(-1, 6)
        gap, directions = _over_hats(setup, zones, gap), _over_hats(setup, zones, directions)
        N = _directions_matrix(directions, screw_rows, mounted.motions)
        f = np.concatenate([np.zeros(3 * count), mounted.work])
        rest = (gap + level).ravel() + load_motion
        touching = tuple(expected_touch(gap, zones)) if state is None else ()
        result, state = solve_balls(C, rest, N, f, start=state, touching=touching)
        new = _relative_motion(setup, result, C, directions, zones, at_rest, screw_rows @ mounted.motions)
        smoothed = _wave(setup, zones, result.forces.reshape(count, n), directions)
        place = _places(setup, zones, result.forces.reshape(count, n))
        moved = max(float(np.abs(new - shift).max()), SLIDE * float(np.abs(place).max()))
        change = max(moved * moving, WAVE * float(np.abs(smoothed - level).max()))
        if not result.converged:
            break
        shift, slid, level = (new, slid + place, smoothed) if moving else (shift, slid, smoothed)
        if change < SETTLED or done == max(updates, ROUNDS):
            break
        done += 1
    forces = result.forces.reshape(count, n)
    vectors = forces[..., None] * directions
    load, angle = _loads(setup, vectors, zones)
    net = vectors.sum(axis=1)
    largest = max(float(load.max()), 1e-300)
    y3 = _tangent(setup)
    status = result.status
    if status == "converged" and _at_rim(setup, forces, zones):
        status = AT_RIM
    elif status == "converged" and change >= SETTLED:
        status = f"directions and gaps still move by {1e9 * change:.1f} nm after {done} updates"
    stations, line = _centreline(mounted, own_rows, _screw_modal(setup, C, result, sides), result.motions[3 * count :])
    free = np.abs(N[:, 3 * count :].T @ result.forces - mounted.work).max(initial=0.0)
    return ReferenceResult(
        status,
        load,
        angle,
        result.motions[: 3 * count].reshape(count, 3),
        stations,
        line,
        sides,
        directions,
        result,
        float(np.abs(net).max()) / largest,
        float(np.abs(net @ y3).max()) / largest,
        float(free) / largest,
        setup.unknowns,
        {**setup.seconds, "contact": perf_counter() - begin},
        done,
    )


def _over_hats(setup: Setup, zones: _Zones, values: Array) -> Array:
    """Means over the pressure hats of values ``(balls, n, ...)`` of the contact nodes."""
    out = np.empty_like(values)
    for part, s in zip(zones.parts, zones.sides, strict=True):
        own = values[:, part]
        flat = np.moveaxis(own, 1, 0).reshape(own.shape[1], -1)
        mean = (mean_weights(setup.patches[s].groove.weights) @ flat).reshape(own.shape[1], own.shape[0], *own.shape[2:])
        out[:, part] = np.moveaxis(mean, 0, 1)
    return out


def _wave(setup: Setup, zones: _Zones, forces: Array, directions: Array) -> Array:
    """Corrections ``(balls, n)`` [m] of all gaps for the places of the contacts on their grids (`hifi.grid_wave`)."""
    out = np.zeros_like(forces)
    for part, s in zip(zones.parts, zones.sides, strict=True):
        wave = setup.patches[s].wave
        if wave is None:
            continue
        own = forces[:, part]
        total = own.sum(axis=1)
        centres = (own @ setup.patches[s].groove.points) / np.maximum(total, 1e-300)[:, None]
        loads = np.linalg.norm(np.einsum("ic,icx->ix", own, directions[:, part]), axis=1)
        out[:, part] = wave.at(loads, centres)[:, None]
    return out


def _spread(setup: Setup, C: Compliance, sides: tuple[int, ...], screw: Array) -> Array:
    """Motion of all modes of ``C`` from that of the screw's modes alone (in the order of ``_modal_rows``)."""
    out = np.zeros(C.coupling.shape[0])
    out[_screw_columns(setup, sides)] = screw
    return out


def _screw_columns(setup: Setup, sides: tuple[int, ...]) -> Index:
    """Where the screw's modes stand among the modes of a compliance."""
    flags: list[bool] = []
    for s in sides:
        body = setup.screw if s < 2 else setup.nut
        if body is not None:
            flags += [s < 2] * body.modes[s].shape[1]
    return np.flatnonzero(np.tile(np.array(flags, dtype=bool), setup.layout.z.size))


def _screw_modal(setup: Setup, C: Compliance, result: ContactResult, sides: tuple[int, ...]) -> Array:
    """Modal forces on the screw, in the order of ``_modal_rows``."""
    return C.amplitude(result.forces)[_screw_columns(setup, sides)]


def _loads(setup: Setup, vectors: Array, zones: _Zones) -> tuple[Array, Array]:
    """Resultant load and contact angle of every contact, ``(balls, 4)`` each."""
    m, count = setup.map, len(vectors)
    load, angle = np.zeros((count, 4)), np.full((count, 4), np.nan)
    z3 = np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    for part, s in zip(zones.parts, zones.sides, strict=True):
        total = vectors[:, part].sum(axis=1)
        load[:, s] = np.linalg.norm(total, axis=1)
        unit = total / np.maximum(load[:, s], 1e-300)[:, None]
        sx, sz = m.signs[s]
        angle[:, s] = np.where(load[:, s] > 0, np.arctan2(sz * (unit @ z3), sx * unit[:, 0]), np.nan)
    return load, angle


def _centreline(mounted: Mounted, rows: Index, modal: Array, rigid: Array) -> tuple[Array, Array]:
    """Stations ``(s,)`` and motions ``(s, 6)`` of the screw's centreline, sorted along the screw."""
    z = np.array(mounted.stations)
    # contact forces press on the screw: along the normals counted from ball to groove
    line = mounted.line + mounted.line_modes[:, :, rows] @ modal
    own = mounted.motions @ rigid
    line = line + np.array([transport(x - mounted.origin) @ own for x in z])
    z, first = np.unique(z, return_index=True)
    return z, line[first]


def _at_rim(setup: Setup, forces: Array, zones: _Zones) -> bool:
    """Whether any ball presses on the outermost nodes of a contact zone."""
    rim = np.concatenate([setup.patches[s].groove.rim for s in zones.sides])
    return bool((forces[:, rim] > 0.0).any())


def expected_touch(gap: Array, zones: _Zones) -> Array:
    """Contact nodes ``(balls, n)`` expected to touch, by their gaps ``(balls, n)`` [m]: the nearest third of each side."""
    out = np.zeros(gap.shape, dtype=bool)
    for part in zones.parts:
        own = gap[:, part]
        third = own.shape[1] // 3
        out[:, part] = own < np.partition(own, third, axis=1)[:, third, None]
    return out


def _groove_errors(setup: Setup, drawn: Specimen, sides: tuple[int, ...]) -> Array:
    """Displacement of each groove by its geometric errors at every contact node, ``(balls, n, 3)`` in the ball's frame."""
    m = setup.map
    x3, z3 = np.array([1.0, 0.0, 0.0]), np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    rows = []
    nominal_centres, radii = nominal_groove_centres(setup.scene), groove_radii(setup.scene)
    for s in sides:
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


def _directions_matrix(directions: Array, screw_rows: Array, motions: Array) -> sp.csr_matrix:
    """N: gap closed by unit motions of each ball (3) and of the screw's unheld rigid motions."""
    count, n, _ = directions.shape
    rows, cols, vals = [], [], []
    for i in range(count):
        rows.append(np.repeat(i * n + np.arange(n), 3))
        cols.append(np.tile(3 * i + np.arange(3), n))
        vals.append(directions[i].ravel())
    for k in range(motions.shape[1]):
        closing = -(screw_rows @ motions[:, k])
        own = np.flatnonzero(closing)
        rows.append(own)
        cols.append(np.full(own.size, 3 * count + k))
        vals.append(closing[own])
    return sp.coo_matrix(
        (np.concatenate(vals), (np.concatenate(rows), np.concatenate(cols))), (count * n, 3 * count + motions.shape[1])
    ).tocsr()


def _screw_rows(setup: Setup, directions: Array, zones: _Zones, origin: float) -> Array:
    """Motion of the screw's contact nodes along their normals by its rigid motion about ``origin``, ``(c, n, 6)``."""
    count, n, _ = directions.shape
    out = np.zeros((count, n, 6))
    for part, s in zip(zones.parts, zones.sides, strict=True):
        if s >= 2:
            continue
        local = setup.patches[s].groove.points
        for i in range(count):
            R = rotation(float(setup.layout.azimuth[i]))
            x = local @ R.T + np.array([0.0, 0.0, setup.layout.z[i] - origin])
            d = directions[i, part] @ R.T
            out[i, part, :3] = d
            out[i, part, 3:] = np.cross(x, d)
    return out


def _relative_motion(
    setup: Setup, result: ContactResult, C: Compliance, directions: Array, zones: _Zones, at_rest: Array, rigid: Array
) -> Array:
    """Motion of each ball's centre relative to each of its grooves, ``(balls, n, 3)``, the same for a side's nodes.

    The groove's own motion is read along the normal from the body's modes and its rigid motion: what the ball's centre
    moves beyond the groove, in the section plane.
    """
    count, n, _ = directions.shape
    y = result.motions[: 3 * count].reshape(count, 3)
    z = C.coupling @ C.amplitude(result.forces) + at_rest
    along = (_modal_motion(C, z) + rigid @ result.motions[3 * count :]).reshape(count, n)
    shift = np.zeros((count, n, 3))
    for part in zones.parts:
        for i in range(count):
            v = np.linalg.lstsq(directions[i, part], along[i, part], rcond=1e-6)[0]
            shift[i, part] = y[i] - v
    y3 = _tangent(setup)
    shift -= (shift @ y3)[..., None] * y3  # motion along the track: `_places`
    return shift


def _tangent(setup: Setup) -> Array:
    """Unit tangent of the track at the ball's centre, ``(3,)``, in the frame of a ball at azimuth 0."""
    return np.array([0.0, np.cos(setup.map.alpha), np.sin(setup.map.alpha)])


def _along_track(setup: Setup, sides: tuple[int, ...]) -> Array:
    """Helical motion of the track at the contact nodes, ``(n, 3)``, of unit length at the ball's centre."""
    m = setup.map
    x = np.concatenate([setup.patches[s].groove.points for s in sides])
    return np.asarray(np.stack([-x[:, 1], x[:, 0], np.full(len(x), m.rg)], axis=1) * (np.cos(m.alpha) / m.R))


def _places(setup: Setup, zones: _Zones, forces: Array) -> Array:
    """Where on its groove each contact presses along the track ``(balls, n)`` [m], the same for a side's nodes, less what
    the contacts of a ball have in common: a ball may stand anywhere on its track.

    A groove is invariant under its helical motion, which therefore changes no gap, and does no work on what presses on it
    without friction: every contact stands abreast of the ball. By linear kinematics a screw that winds up by theta moves
    its contacts R theta/2 along, and R theta^2/2 out of their section; what is moved so far is taken back. forces: of the
    contact nodes along their normals, ``(balls, n)`` [N].
    """
    y3 = _tangent(setup)
    middle = np.full((len(forces), len(zones.sides)), np.nan)
    for k, (part, s) in enumerate(zip(zones.parts, zones.sides, strict=True)):
        total = forces[:, part].sum(axis=1)
        moment = forces[:, part] @ (setup.patches[s].groove.points @ y3)
        middle[:, k] = np.divide(moment, total, out=middle[:, k], where=total > 0.0)
    closed = np.isfinite(middle)
    common = np.where(closed, middle, 0.0).sum(axis=1) / np.maximum(closed.sum(axis=1), 1)
    place = np.where(closed, middle - common[:, None], 0.0)
    return np.repeat(place, [part.stop - part.start for part in zones.parts], axis=1)
