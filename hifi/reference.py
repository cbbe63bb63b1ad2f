"""The 3D elastic-contact reference of a ball screw or bearing: the contact of all balls of a prepared geometry.

Contact is unilateral and frictionless on matching grids of ball and groove, the balls' rigid motions free. Pressures are
hats on the grid (`hifi.elements.pressures`), and what may not be negative is the mean of the gap over each hat. Gaps are
exact distances from the ball's centre; directions and gaps follow the motion of ball and groove to convergence.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from rollbench.hifi.contact.balls import State, solve_balls
from rollbench.hifi.contact.result import ContactResult
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
from rollbench.hifi.linear_algebra.response import transport
from rollbench.hifi.setup import Setup
from rollbench.hifi.shaft.mounting import Mounted
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
    settle, else 0; frozen: loads with directions and gaps frozen at the nominal state ``(n, 4)`` [N], where they were asked
    for."""

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
    frozen: Array | None = None


def solve_reference(
    setup: Setup,
    scene: Scene,
    *,
    updates: int = ROUNDS,
    sides: tuple[int, ...] | None = None,
    leave_out: frozenset[str] = frozenset(),
    frozen: bool = False,
    step: Callable[[str], None] = lambda _: None,
) -> ReferenceResult:
    """Loads of a load case or error pattern of a prepared geometry.

    updates: how often directions and gaps follow the motion at most (0: frozen at the nominal state, gaps follow the grid's
    wave alone); sides: those that may touch (all prepared ones if left out); leave_out: some of ``INGREDIENTS``;
    frozen: whether its loads are found too, from the round that both have in common; step: hears of every round of a
    solution that takes long. Raises ValueError for other ingredients.
    """
    if leave_out - set(INGREDIENTS):
        raise ValueError(f"unknown ingredients {sorted(leave_out - set(INGREDIENTS))}")
    with threadpool_limits(1):  # many small factors: the threads of two BLAS libraries only wait for one another
        return _solve(setup, scene, updates, setup.sides if sides is None else sides, leave_out, frozen, step)


class _Round(NamedTuple):
    """Contacts for given places of balls and grooves: result, the state to go on from, normals ``(balls, n, 3)``, motion of
    the gaps by the screw's rigid motions ``(pairs, k)``, forces ``(balls, n)``, loads and angles ``(balls, 4)``."""

    result: ContactResult
    state: State
    directions: Array
    by_screw: Array
    forces: Array
    load: Array
    angle: Array


class _Case:
    """A load case of a prepared geometry, round by round."""

    def __init__(self, setup: Setup, scene: Scene, sides: tuple[int, ...], leave_out: frozenset[str]) -> None:
        m = setup.map
        self.setup, self.sides, self.zones = setup, sides, zones_of(setup, sides)
        self.mounted = mounted_screw(setup, scene, leave_out)
        self.C = compliance_of(setup, self.mounted, sides, leave_out)
        self.rows = modal_rows(setup, sides)
        self.at_rest = spread(setup, self.C, sides, self.mounted.loads[self.rows])
        drawn = specimen(scene, setup.layout)
        nominal = np.concatenate([setup.patches[s].groove.points - np.array([m.R, 0.0, 0.0]) for s in sides])
        self.arms = nominal[None] + groove_errors(setup, drawn, sides)
        self.radii, self.along = drawn.ball_radius, along_track(setup, sides)
        self.load_motion = modal_motion(self.C, self.at_rest)

    def first(self) -> _Round:
        """Contacts with balls and grooves in their nominal places."""
        return self._round(np.zeros((1, 1, 3)), np.zeros((1, 1)), np.zeros((1, 1)), None)

    def after(self, last: _Round, *, moving: bool) -> _Round:
        """Contacts in the places that the last round says; moving: whether normals follow, or only the grid's wave."""
        shift, slid = np.zeros((1, 1, 3)), np.zeros((1, 1))
        if moving:
            shift, slid = relative_motion(
                self.setup, last.result, self.C, last.directions, self.zones, self.at_rest, last.by_screw
            )
        level = wave_gaps(self.setup, self.zones, last.forces, last.directions)
        return self._round(shift, slid, level, last.state)

    def _round(self, shift: Array, slid: Array, level: Array, start: State | None) -> _Round:
        """Contacts for motions of the balls from their grooves (`relative_motion`) and changes of the gaps [m]."""
        setup, zones, mounted = self.setup, self.zones, self.mounted
        arms = self.arms - shift
        length = np.linalg.norm(arms, axis=2)
        directions = arms / length[..., None]
        back = shift + slid[..., None] * self.along  # the solver's gaps lose it again
        gap = length - self.radii[:, None] + np.einsum("ink,ink->in", directions, np.broadcast_to(back, arms.shape))
        by_screw = over_hats(setup, zones, screw_rows(setup, directions, zones, mounted.origin)).reshape(-1, 6)
        gap, directions = over_hats(setup, zones, gap), over_hats(setup, zones, directions)
        N = directions_matrix(directions, by_screw, mounted.motions)
        f = np.concatenate([np.zeros(3 * len(arms)), mounted.work])
        rest = (gap + level).ravel() + self.load_motion
        touching = tuple(expected_touch(gap, zones)) if start is None else ()
        result, state = solve_balls(self.C, rest, N, f, start=start, touching=touching)
        forces = result.forces.reshape(gap.shape)
        load, angle = _loads(setup, forces[..., None] * directions, zones)
        return _Round(result, state, directions, by_screw @ mounted.motions, forces, load, angle)

    def settled(self, last: _Round, most: int, step: Callable[[int], None], *, moving: bool) -> tuple[_Round, int, float]:
        """The round whose loads stand still, updates until then, ``most`` at most, and what more may change of a load."""
        found = [last.load]
        for done in range(most + 1):
            left = left_over(found)
            if not last.result.converged or left <= SETTLED * _mean(last.load) or done == most:
                break
            step(done + 2)
            last = self.after(last, moving=moving)
            found = [*found[-2:], last.load]
        return last, done, left


def _solve(
    setup: Setup,
    scene: Scene,
    updates: int,
    sides: tuple[int, ...],
    leave_out: frozenset[str],
    frozen: bool,
    step: Callable[[str], None],
) -> ReferenceResult:
    begin = perf_counter()

    def tell(number: int) -> None:
        if perf_counter() - begin > SLOW:
            step(f"contacts of {scene.name}: round {number}, {perf_counter() - begin:.0f} s")

    moving = updates > 0 and "moving normals" not in leave_out
    case = _Case(setup, scene, tuple(s for s in setup.sides if s in sides), leave_out)
    count, zones, mounted, C = setup.layout.z.size, case.zones, case.mounted, case.C
    tell(1)
    first = case.first()
    last, done, left = case.settled(first, updates or ROUNDS, tell, moving=moving)
    seconds = perf_counter() - begin
    still = case.settled(first, ROUNDS, tell, moving=False)[0] if frozen and moving else last
    result, load, vectors = last.result, last.load, last.forces[..., None] * last.directions
    net = vectors.sum(axis=1)
    largest = max(float(load.max()), 1e-300)
    y3 = tangent(setup)
    status, may_move = result.status, 0.0
    if status == "converged" and _at_rim(setup, last.forces, zones):
        status = AT_RIM
    elif status == "converged" and left > SETTLED * _mean(load):
        status = f"not settled: loads may still move by {left:.2g} N after {done} updates of directions and gaps"
        may_move = left
    stations, line = _centreline(
        mounted, case.rows, screw_modal(setup, C, result, zones.sides), result.motions[3 * count :]
    )
    free = np.abs(last.by_screw.T @ result.forces + mounted.work).max(initial=0.0)
    return ReferenceResult(
        status,
        load,
        last.angle,
        result.motions[: 3 * count].reshape(count, 3),
        stations,
        line,
        zones.sides,
        last.directions,
        result,
        float(np.abs(net).max()) / largest,
        float(np.abs(net @ y3).max()) / largest,
        float(free) / largest,
        setup.unknowns,
        {**setup.seconds, "contact": seconds},
        done,
        may_move,
        still.load if frozen else None,
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
