"""Compliance between all contacts of a prepared geometry: bodies with their modes, balls, and the screw on its supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from rollbench.hifi.contact.compliance import BallBlock, Compliance, coupled
from rollbench.hifi.setup import Setup
from rollbench.hifi.shaft.mounting import Mounted, beam_stretch, mount
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class Zones:
    """Contact nodes of one ball, side after side: sides, their slices, number."""

    sides: tuple[int, ...]
    parts: tuple[slice, ...]
    size: int


def zones_of(setup: Setup, sides: tuple[int, ...]) -> Zones:
    """Contact nodes of one ball on these sides."""
    ends = np.cumsum([0] + [len(setup.patches[s].groove.A) for s in sides])
    return Zones(sides, tuple(slice(int(a), int(b)) for a, b in pairwise(ends)), int(ends[-1]))


@dataclass(frozen=True)
class PlacedSet:
    """A prepared geometry on a shaft: the scene whose errors it has, sides that may touch; shift: station [m] of the shaft
    at which the geometry's own stations begin; housing: number of the one that carries its nut among those that can move
    (None: the nut is held); offset: shift of the nut along z against what holds it [m]."""

    setup: Setup
    scene: Scene
    sides: tuple[int, ...]
    shift: float = 0.0
    housing: int | None = None
    offset: float = 0.0

    @property
    def count(self) -> int:
        """Number of balls."""
        return self.setup.layout.z.size


def compliance_of(
    sets: Sequence[PlacedSet], mounted: Mounted, leave_out: frozenset[str] = frozenset()
) -> tuple[Compliance, Index]:
    """Compliance of all contact nodes, set after set, ball after ball, side after side; of each of its modes the row among
    those of all bodies: screws and carried nuts as they are mounted, then the nuts that are held."""
    held = [p.setup for p in sets if p.setup.nut is not None and p.housing is None]
    G = block_diag(mounted.G, *(_nut_coupling(setup, leave_out) for setup in held))
    screw = 0
    carried = sum(p.setup.screw.stretch.modes for p in sets)
    after = len(mounted.G)
    blocks: list[BallBlock] = []
    modes: list[Array] = []
    rows: list[Index] = []
    for p in sets:
        setup, zones = p.setup, zones_of(p.setup, p.sides)
        nut = after if p.housing is None else carried
        block = ball_block(setup, p.sides, rigid=bool(leave_out & {"finite ball", "patch coupling"}))
        for i in range(p.count):
            pieces = []
            for nodes, s in zip(zones.parts, p.sides, strict=True):
                body = setup.screw if s < 2 else setup.nut
                if body is None:
                    continue
                V = np.zeros((zones.size, body.modes[s].shape[1]))
                V[nodes] = body.modes[s]
                pieces.append(V)
                rows.append((screw if s < 2 else nut) + _first(setup, s, i) + np.arange(V.shape[1]))
            blocks.append(block)
            modes.append(np.hstack(pieces))
        screw += setup.screw.stretch.modes
        size = 0 if setup.nut is None else len(setup.nut.G)
        carried, after = (carried, after + size) if p.housing is None else (carried + size, after)
    pick = np.concatenate(rows)
    return coupled(blocks, modes, G[np.ix_(pick, pick)]), pick


def _nut_coupling(setup: Setup, leave_out: frozenset[str]) -> Array:
    """Coupling of the modes of an elastic nut [m/N]; rigid at large where that ingredient is left out."""
    assert setup.nut is not None
    if leave_out & {"elastic nut", "patch coupling"}:
        return local_only(setup.nut.G, _mode_counts(setup, False))
    return setup.nut.G


def _first(setup: Setup, side: int, ball: int) -> int:
    """First row of a contact's modes in the coupling of its body."""
    counts = _mode_counts(setup, side < 2)
    body_sides = [s for s in setup.sides if (s < 2) == (side < 2)]
    return ball * sum(counts) + sum(counts[: body_sides.index(side)])


def _mode_counts(setup: Setup, screw: bool) -> list[int]:
    body = setup.screw if screw else setup.nut
    assert body is not None
    return [body.modes[s].shape[1] for s in setup.sides if (s < 2) == screw]


def ball_block(setup: Setup, sides: tuple[int, ...], *, rigid: bool) -> BallBlock:
    """Compliance of a ball and its grooves' patches between pairs of ``sides``; rigid: ball rigid beyond its patches."""
    local = tuple(setup.patches[s].local for s in sides)
    ball = setup.ball
    if rigid:
        return BallBlock(local, tuple(np.zeros((len(a), 0)) for a in local), np.zeros((0, 0)))
    ends = np.cumsum([0] + [ball.modes[s].shape[1] for s in setup.sides])
    pick = np.concatenate([np.arange(ends[k], ends[k + 1]) for k, s in enumerate(setup.sides) if s in sides])
    return BallBlock(local, tuple(ball.modes[s] for s in sides), ball.G[np.ix_(pick, pick)])


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
    stations = np.repeat(setup.layout.z, len(counts))
    beam = beam_stretch(setup.screw.rigid, stations, full, setup.section)
    m = full.modes
    F = beam.F.copy()
    F[:m, :m] += local_only(full.F[:m, :m] - beam.F[:m, :m], counts)
    return mount(replace(beam, F=F), scene, setup.section)


def modal_motion(C: Compliance, z: Array) -> Array:
    """Motion of every contact node along its normal by modal motions z ``(r,)``."""
    return np.concatenate([V @ z[c] for V, c in zip(C.modes, C.columns, strict=True)])
