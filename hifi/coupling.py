"""Compliance between all contacts of a prepared geometry: bodies with their modes, balls, and the screw on its supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from rollbench.hifi.condensation.responses import Modal
from rollbench.hifi.contact.compliance import BallBlock, Compliance, coupled
from rollbench.hifi.setup import Setup
from rollbench.hifi.shaft.mounting import Mounted, beam_stretch, mount
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.parts import Scene


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

    @cached_property
    def zones(self) -> tuple[tuple[slice, int], ...]:
        """Contact nodes of one ball, side after side: their slice, and the side."""
        ends = np.cumsum([0] + [len(self.setup.patches[s].groove.A) for s in self.sides]).tolist()
        return tuple((slice(a, b), s) for (a, b), s in zip(pairwise(ends), self.sides, strict=True))

    @property
    def nodes(self) -> int:
        """Number of the contact nodes of one ball."""
        return int(self.zones[-1][0].stop)


def compliance_of(
    sets: Sequence[PlacedSet], mounted: Mounted, leave_out: frozenset[str] = frozenset()
) -> tuple[Compliance, Index]:
    """Compliance of all contact nodes, set after set, ball after ball, side after side; of each of its modes the row among
    those of all bodies: screws and carried nuts as they are mounted, then the nuts that are held."""
    screw, carried, held = 0, sum(p.setup.screw.stretch.modes for p in sets), len(mounted.G)
    couplings, blocks, modes, rows = [mounted.G], list[BallBlock](), list[Array](), list[Index]()
    for p in sets:
        nut = p.setup.nut
        first = (screw, held if p.housing is None else carried)
        block = ball_block(p.setup, p.sides, rigid=bool(leave_out & {"finite ball", "patch coupling"}))
        for i in range(p.count):
            pieces = []
            for nodes, s in p.zones:
                if (body := p.setup.body(s)) is not None:
                    V = np.zeros((p.nodes, body.modes[s].shape[1]))
                    V[nodes] = body.modes[s]
                    pieces.append(V)
                    rows.append(first[s >= 2] + body.rows(s, i))
            blocks.append(block)
            modes.append(np.hstack(pieces))
        screw += p.setup.screw.stretch.modes
        if nut is not None and p.housing is None:
            couplings.append(local_only(nut.G, nut) if leave_out & {"elastic nut", "patch coupling"} else nut.G)
            held += len(nut.G)
        elif nut is not None:
            carried += len(nut.G)
    pick = np.concatenate(rows)
    return coupled(blocks, modes, block_diag(*couplings)[np.ix_(pick, pick)]), pick


def ball_block(setup: Setup, sides: tuple[int, ...], *, rigid: bool) -> BallBlock:
    """Compliance of a ball and its grooves' patches between pairs of ``sides``; rigid: ball rigid beyond its patches."""
    local = tuple(setup.patches[s].local for s in sides)
    ball = setup.ball
    if rigid:
        return BallBlock(local, tuple(np.zeros((len(a), 0)) for a in local), np.zeros((0, 0)))
    pick = np.concatenate([ball.rows(s) for s in sides])
    return BallBlock(local, tuple(ball.modes[s] for s in sides), ball.G[np.ix_(pick, pick)])


def local_only(G: Array, body: Modal) -> Array:
    """Coupling G of the modes of a body that is rigid at large: every contact keeps the mean self response of its side,
    nothing else."""
    out = np.zeros_like(G)
    for s in body.modes:
        own = [np.ix_(rows, rows) for rows in (body.rows(s, i) for i in range(len(G) // body.per_ball))]
        mean = np.mean([G[block] for block in own], axis=0)
        for block in own:
            out[block] = mean
    return out


def mounted_screw(setup: Setup, scene: Scene, leave_out: frozenset[str] = frozenset()) -> Mounted:
    """The screw under a scene's supports and loads; without the 3D shaft it is a beam with the same local response."""
    full, m = setup.screw.stretch, setup.screw.stretch.modes
    if not leave_out & {"3D shaft", "patch coupling"} or full.rigid:
        return mount(full, scene, setup.section)
    stations = np.repeat(setup.layout.z, len(setup.screw.modes))
    beam = beam_stretch(setup.screw.rigid, stations, full, setup.section)
    F = beam.F.copy()
    F[:m, :m] += local_only(full.F[:m, :m] - beam.F[:m, :m], setup.screw)
    return mount(replace(beam, F=F), scene, setup.section)


def modal_motion(C: Compliance, z: Array) -> Array:
    """Motion of every contact node along its normal by modal motions z ``(r,)``."""
    return np.concatenate([V @ z[c] for V, c in zip(C.modes, C.columns, strict=True)])
