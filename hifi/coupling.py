"""Compliance between all contacts of a prepared geometry: bodies with their modes, balls, and the screw on its supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from rollbench.hifi.contact.compliance import BallBlock, Compliance, coupled
from rollbench.hifi.contact.result import ContactResult
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


def compliance_of(
    setup: Setup, mounted: Mounted, sides: tuple[int, ...], leave_out: frozenset[str] = frozenset()
) -> Compliance:
    """Compliance of all contact nodes, ball after ball, side after side."""
    zones, count = zones_of(setup, sides), setup.layout.z.size
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


def modal_rows(setup: Setup, sides: tuple[int, ...]) -> Index:
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
    stations = np.repeat(setup.layout.z, len(counts))
    beam = beam_stretch(setup.screw.rigid, stations, full, setup.section)
    m = full.modes
    F = beam.F.copy()
    F[:m, :m] += local_only(full.F[:m, :m] - beam.F[:m, :m], counts)
    return mount(replace(beam, F=F), scene, setup.section)


def spread(setup: Setup, C: Compliance, sides: tuple[int, ...], screw: Array) -> Array:
    """Motion of all modes of ``C`` from that of the screw's modes alone (in the order of `modal_rows`)."""
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


def screw_modal(setup: Setup, C: Compliance, result: ContactResult, sides: tuple[int, ...]) -> Array:
    """Modal forces on the screw, in the order of `modal_rows`."""
    return C.amplitude(result.forces)[_screw_columns(setup, sides)]


def modal_motion(C: Compliance, z: Array) -> Array:
    """Motion of every contact node along its normal by modal motions z ``(r,)``."""
    return np.concatenate([V @ z[c] for V, c in zip(C.modes, C.columns, strict=True)])
