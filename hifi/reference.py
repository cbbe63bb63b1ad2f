"""The 3D elastic-contact reference of a ball screw or bearing: the contact of all balls of a prepared geometry.

Contact is unilateral and frictionless on matching grids of ball and groove, the balls' rigid motions free. Pressures are
hats on the grid (`hifi.pressures`), and what may not be negative is the mean of the gap over each hat. Gaps are exact
distances from the ball's centre; directions and gaps follow the motion of ball and groove to convergence.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from hifi.balls import State, solve_balls
from hifi.contact import ContactResult
from hifi.contact_kinematics import (
    along_track,
    directions_matrix,
    expected_touch,
    groove_errors,
    over_hats,
    places,
    relative_motion,
    screw_rows,
    tangent,
    wave_gaps,
)
from hifi.coupling import Zones, compliance_of, modal_motion, modal_rows, mounted_screw, screw_modal, spread, zones_of
from hifi.mounting import Mounted
from hifi.response import transport
from hifi.setup import Setup
from meshes.arrays import Array, Index
from meshes.errors import specimen
from meshes.parts import Scene

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
    done = 0
    while True:
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
        new = relative_motion(setup, result, C, directions, zones, at_rest, by_screw @ mounted.motions)
        smoothed = wave_gaps(setup, zones, result.forces.reshape(count, n), directions)
        place = places(setup, zones, result.forces.reshape(count, n))
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
    y3 = tangent(setup)
    status = result.status
    if status == "converged" and _at_rim(setup, forces, zones):
        status = AT_RIM
    elif status == "converged" and change >= SETTLED:
        status = f"directions and gaps still move by {1e9 * change:.1f} nm after {done} updates"
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
    )


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
