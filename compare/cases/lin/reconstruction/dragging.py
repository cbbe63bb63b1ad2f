"""The 3D reference with balls that do not turn, so that grooves slide on them with friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.compare.reference.store import Run
from rollbench.compare.reference.tasks import settings_of
from rollbench.hifi.coupling import PlacedSet, modal_motion, mounted_screw
from rollbench.hifi.reference import ROUNDS, Case, Round
from rollbench.hifi.setup import Setup, prepare
from rollbench.hifi.shaft.frame import Frame
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import Scene


class Dragging(Case):
    """A load case whose contacts slide across their grooves, with ``mu`` times their loads against an axial motion of the
    screw with its load (negative: against one back).

    The frictions of a ball's two contacts balance. On a body, a force across a contact's load is taken as one through the
    arc's centre, which normal forces on its nodes make; its moment about that centre, the arc's radius times mu times the
    load, is left out.
    """

    def __init__(self, setup: Setup, scene: Scene, mu: float) -> None:
        """A case of one set."""
        super().__init__((PlacedSet(setup, scene, setup.sides),), Frame.of(scene), mounted_screw(setup, scene))
        self.mu, self.smooth, self.still = mu, self.mounted, self.at_rest

    def after(self, last: Round, *, moving: bool) -> Round:
        """The next round, with the friction of the last one's loads."""
        across = self.across(last).ravel()
        self.at_rest = self.still + self.C.coupling @ self.C.amplitude(across)
        self.load_motion = modal_motion(self.C, self.at_rest)
        self.mounted = replace(self.smooth, work=self.smooth.work + last.by_rigid.T @ across)
        return super().after(last, moving=moving)

    def across(self, last: Round) -> Array:
        """Forces ``(balls, n)`` [N] along the nodes' normals whose resultants are the contacts' friction."""
        (forces,), (normals,), (placed,) = last.forces, last.directions, self.sets
        section = placed.setup.map.axes()[[0, 2]]
        out = np.zeros_like(forces)
        for nodes, _ in placed.zones:
            for k in np.flatnonzero(forces[:, nodes].any(axis=1)):
                load, n = forces[k, nodes], normals[k, nodes] @ section.T
                x, z = load @ n
                friction = self.mu * np.sign(x * z) * np.array([-z, x])
                out[k, nodes] = load * (n @ np.linalg.solve((load * n.T) @ n, friction))
        return out


def with_sliding(scenes: Sequence[Scene], runs: Sequence[Run], mu: float, cache: Path | None) -> list[Run]:
    """Runs of one geometry with the loads and contact angles of balls that do not turn. Raises ValueError where they do not
    settle."""
    settings = settings_of(scenes, runs[0].level)
    setup = prepare(scenes[0], runs[0].sides, settings, scenes=scenes[1:], cache=Cache(cache))
    out = []
    for scene, run in zip(scenes, runs, strict=True):
        ended = Dragging(setup, scene, mu).end(ROUNDS)
        if ended.status != "converged":
            raise ValueError(f"{scene.name}: {ended.status}")
        out.append(replace(run, load=ended.load, angle=np.degrees(ended.contact_angle)))
    return out
