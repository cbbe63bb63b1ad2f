"""The 3D elastic-contact reference of a ball screw or bearing: the contact of all balls of a prepared geometry.

Contact is unilateral and frictionless on matching grids of ball and groove, the balls' rigid motions free. Pressures are
hats on the grid (`hifi.pressures`), and what may not be negative is the mean of the gap over each hat. Gaps are exact
distances from the ball's centre; directions and gaps follow the motion of ball and groove to convergence.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from rollbench.hifi.balls import State, solve_balls
from rollbench.hifi.contact import ContactResult
from rollbench.hifi.contact_kinematics import (
    along_track,
    directions_matrix,
    expected_touch,
    groove_errors,
    over_hats,
    relative_motion,
    screw_rows,
    tangent,
    wave_gaps,
)
from rollbench.hifi.coupling import (
    Zones,
    compliance_of,
    modal_motion,
    modal_rows,
    mounted_screw,
    screw_modal,
    spread,
    zones_of,
)
from rollbench.hifi.mounting import Mounted
from rollbench.hifi.response import transport
from rollbench.hifi.setup import Setup
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.errors import specimen
from rollbench.meshes.parts import Scene

#: Change of any contact's load that is left when directions and gaps count as settled, over the mean load: a hundredth of
#: what the mesh leaves open on the finest level (0.1 %).
SETTLED = 1e-5
#: Times at most that directions and gaps follow the motion; most scenes take three or four.
ROUNDS = 30
#: Largest ratio of changes by which a rest is told: slower ones are as good as none.
SLOWEST = 0.99
AT_RIM = "a contact reaches the rim of its patch: the expected semi-axes are too small"
#: Seconds after which every round of a solution is told.
SLOW = 5.0
#: Ingredients of the reference that can be left out, to see what they change.
INGREDIENTS = ("elastic nut", "3D shaft", "finite ball", "patch coupling", "moving normals")


@dataclass(frozen=True)
class ReferenceResult:
    """Loads ``(n, 4)`` [N], contact angles ``(n, 4)`` [rad], ball motions ``(n, 3)`` [m], centreline: stations ``(s,)`` [m]
    and motions ``(s, 6)``, contact record, residuals, unknowns (of the equivalent monolithic mesh), seconds by stage,
    updates of directions and gaps, status; moving: what more of them may still change of any load [N] where these did not
    settle, else 0."""

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
    moving: float


def solve_reference(
    setup: Setup,
    scene: Scene,
    *,
    updates: int = ROUNDS,
    sides: tuple[int, ...] | None = None,
    leave_out: frozenset[str] = frozenset(),
    step: Callable[[str], None] = lambda _: None,
) -> ReferenceResult:
    """Loads of a load case or error pattern of a prepared geometry.

    updates: how often directions and gaps follow the motion at most (0: frozen at the nominal state, gaps follow the grid's
    wave alone); sides: those that may touch (all prepared ones if left out); leave_out: some of ``INGREDIENTS``;
    step: hears of every round of a solution that takes long. Raises ValueError for other ingredients.
    """
    if leave_out - set(INGREDIENTS):
        raise ValueError(f"unknown ingredients {sorted(leave_out - set(INGREDIENTS))}")
    with threadpool_limits(1):  # many small factors: the threads of two BLAS libraries only wait for one another
        return _solve(setup, scene, updates, setup.sides if sides is None else sides, leave_out, step)


def _solve(
    setup: Setup, scene: Scene, updates: int, sides: tuple[int, ...], leave_out: frozenset[str], step: Callable[[str], None]
) -> ReferenceResult:
    begin = perf_counter()
    sides = tuple(s for s in setup.sides if s in sides)
    moving = updates > 0 and "moving normals" not in leave_out
    drawn = specimen(scene, setup.layout)
    count, m, zones = setup.layout.z.size, setup.map, zones_of(setup, sides)
    mounted = mounted_screw(setup, scene, leave_out)
    C = compliance_of(setup, mounted, sides, leave_out)
    n = zones.size
    nominal = np.concatenate([setup.patches[s].groove.points - np.array([m.R, 0.0, 0.0]) for s in sides])
    errors = groove_errors(setup, drawn, sides)
    own_rows = modal_rows(setup, sides)
    at_rest = spread(setup, C, sides, mounted.loads[own_rows])
    load_motion = modal_motion(C, at_rest)
    shift, level, slid = np.zeros((count, n, 3)), np.zeros((count, n)), np.zeros((count, n))
    along = along_track(setup, sides)
    state: State | None = None
    found: list[Array] = []
    done = 0
    while True:
        if perf_counter() - begin > SLOW:
            step(f"contacts of {scene.name}: round {done + 1}, {perf_counter() - begin:.0f} s")
        arms = nominal[None] + errors - shift
        length = np.linalg.norm(arms, axis=2)
        directions = arms / length[..., None]
        back = shift + slid[..., None] * along  # the solver's gaps lose it again
        gap = length - drawn.ball_radius[:, None] + np.einsum("ink,ink->in", directions, back)
        by_screw = over_hats(setup, zones, screw_rows(setup, directions, zones, mounted.origin)).reshape(-1, 6)
        gap, directions = over_hats(setup, zones, gap), over_hats(setup, zones, directions)
        N = directions_matrix(directions, by_screw, mounted.motions)
        f = np.concatenate([np.zeros(3 * count), mounted.work])
        rest = (gap + level).ravel() + load_motion
        touching = tuple(expected_touch(gap, zones)) if state is None else ()
        result, state = solve_balls(C, rest, N, f, start=state, touching=touching)
        forces = result.forces.reshape(count, n)
        vectors = forces[..., None] * directions
        load, angle = _loads(setup, vectors, zones)
        found = [*found[-2:], load]
        left = left_over(found)
        if not result.converged or left <= SETTLED * _mean(load) or done == (updates or ROUNDS):
            break
        if moving:
            shift, slid = relative_motion(setup, result, C, directions, zones, at_rest, by_screw @ mounted.motions)
        level = wave_gaps(setup, zones, forces, directions)
        done += 1
    net = vectors.sum(axis=1)
    largest = max(float(load.max()), 1e-300)
    y3 = tangent(setup)
    status, may_move = result.status, 0.0
    if status == "converged" and _at_rim(setup, forces, zones):
        status = AT_RIM
    elif status == "converged" and left > SETTLED * _mean(load):
        status = f"not settled: loads may still move by {left:.2g} N after {done} updates of directions and gaps"
        may_move = left
    stations, line = _centreline(mounted, own_rows, screw_modal(setup, C, result, sides), result.motions[3 * count :])
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
        may_move,
    )


def left_over(loads: Sequence[Array]) -> float:
    """What the rounds to come would still change at most of any load, by the loads of the last three: the rest of a
    geometric series, last change x ratio / (1 - ratio); by two the slowest series, by one infinite."""
    changes = [float(np.abs(b - a).max()) for a, b in pairwise(loads[-3:])]
    if not changes:
        return np.inf
    ratio = min(changes[1] / changes[0], SLOWEST) if len(changes) == 2 and changes[0] > 0.0 else SLOWEST
    return changes[-1] * ratio / (1.0 - ratio)


def _mean(load: Array) -> float:
    """Mean load [N] of the contacts that carry any."""
    return float(load[load > 0.0].mean()) if load.any() else 0.0


def _loads(setup: Setup, vectors: Array, zones: Zones) -> tuple[Array, Array]:
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


def _at_rim(setup: Setup, forces: Array, zones: Zones) -> bool:
    """Whether any ball presses on the outermost nodes of a contact zone."""
    rim = np.concatenate([setup.patches[s].groove.rim for s in zones.sides])
    return bool((forces[:, rim] > 0.0).any())
