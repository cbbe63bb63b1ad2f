"""Compliance between contacts from a condensed 3D model, read from a file.

The file knows motions along the nominal normals; the low-order bodies keep what lies across them. The screw's beam beyond
the nut, its supports and loads stay those of the low-order model.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollbench.lowfi.compliance.between import contact_frames
from rollbench.lowfi.compliance.bodies import BallCompliance, ball_compliance, whole_body
from rollbench.lowfi.compliance.parts import REFINED, Backend, geometry_only, grooved_section, held_at
from rollbench.lowfi.compliance.tube import clamped, motion_rows
from rollbench.meshes.arrays import Array
from rollbench.meshes.condensed import CondensedBodies, geometry_digest, load_condensed
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import SIDE_SIGNS, SIDES, Scene

#: Bodies that a file holds, besides the balls.
PARTS = ("screw", "nut")


@dataclass(frozen=True)
class Condensed:
    """Bodies of a condensed 3D model for one geometry; parts: those that are taken from it, with the laws of the contacts
    on their grooves and the ball's share of these."""

    bodies: CondensedBodies
    parts: tuple[str, ...] = PARTS

    @staticmethod
    def read(path: Path, scene: Scene) -> Condensed:
        """Read a file for a scene. Raises ValueError for a damaged one or one of other parts, OSError."""
        bodies = load_condensed(path)
        if bodies.geometry != geometry_digest(scene):
            raise ValueError("made for other parts (track, screw, nut, balls or [solid] differ)")
        return Condensed(bodies)

    @property
    def whole(self) -> bool:
        """Whether both bodies are those of the file."""
        return self.parts == PARTS

    def sides_of(self, sides: list[int]) -> list[int]:
        """Those of some sides whose contacts follow the file."""
        return [s for s in sides if s in self.bodies.sides and ("screw" if s < 2 else "nut") in self.parts]

    def correct(self, scene: Scene, layout: BallLayout, sides: list[int], total: Array, backend: Backend) -> Array:
        """Compliance of a body with its part along the normals from the file; ``total``: the low-order one on these sides,
        ball after ball, supports and beam included.

        What the file does not know, across the normals and on other sides, follows what all contacts move along theirs
        as in the low-order body, so that the result stays positive semidefinite: with A, B, D the blocks along, between
        and across, A' for A gives B' = A' A^-1 B and D' = D + B^T A^-1 (A' - A) A^-1 B.
        """
        N, screw = layout.z.size, sides[0] < 2
        geometry = geometry_only(scene)
        if held_at(geometry, screw) == "rigid" or ("screw" if screw else "nut") not in self.parts:
            return total
        x, axes = contact_frames(scene, layout, screw)
        held = whole_body(scene, layout, screw, backend)
        if screw and held_at(geometry, True) == "section":
            section = grooved_section(geometry, True)
            held = held + clamped(motion_rows(x, axes), np.repeat(x[:, 2], 2), (self.bodies.base, 0.0), "low", section)
        known = [s for s in ((0, 1) if screw else (2, 3)) if s in self.bodies.sides]
        file_G = self.bodies.screw if screw else self.bodies.nut
        if file_G.shape != (N * len(known),) * 2:
            raise ValueError("the file of condensed bodies has another number of contacts")
        rows = normal_rows(scene, N, known)
        change = file_G - rows @ held @ rows.T
        common = [s for s in sides if s in known]
        if not common:
            return total
        pick = np.concatenate([np.arange(N)[:, None] * len(known) + known.index(s) for s in common], axis=1).ravel()
        along, across = directions(scene, N, sides, common)
        A, B = along @ total @ along.T, along @ total @ across.T
        follow = np.linalg.solve(A, B)
        spread = along + follow @ across
        return np.asarray(total + spread.T @ change[np.ix_(pick, pick)] @ spread)

    def ball(self, scene: Scene, semi_axes: tuple[float, float]) -> BallCompliance:
        """The ball from the file: what opposite contacts do to themselves and each other, and across."""
        D, sides = self.bodies.ball, [int(s) for s in self.bodies.sides]
        closed = ball_compliance(scene, semi_axes, REFINED)
        pairs = [(sides.index(a), sides.index(3 - a)) for a in (0, 1) if a in sides and 3 - a in sides]
        alone = float(np.mean([0.5 * (D[a, a] + D[b, b]) + D[a, b] for a, b in pairs]))
        across = closed.sign * closed.g**2
        if len(pairs) == 2:
            (a, b), (c, d) = pairs
            across = 0.25 * float(D[a, c] + D[a, d] + D[b, c] + D[b, d])
        return BallCompliance(alone - 2.0 * abs(across), 0.0, float(np.sqrt(abs(across))), float(np.sign(across)))

    def describe(self) -> str:
        """Words for the record."""
        names = ", ".join(SIDES[int(s)] for s in self.bodies.sides)
        level = self.bodies.level
        bodies = " and ".join(self.parts) if self.parts != PARTS else "screw, nut and balls"
        return f"{bodies} from a condensed 3D model (mesh level {level}, sides {names}), along the normals"


def normal_rows(scene: Scene, N: int, sides: list[int]) -> Array:
    """Motion along the nominal normals, ball after ball and side after side, from arrays that go side after side."""
    beta = scene.track.contact_angle
    out = np.zeros((N * len(sides), 4 * N))
    for k, s in enumerate(sides):
        direction = np.array(SIDE_SIGNS[s]) * np.array([np.cos(beta), np.sin(beta)])
        for i in range(N):
            first = 2 * ((s % 2) * N + i)
            out[i * len(sides) + k, first : first + 2] = direction
    return out


def directions(scene: Scene, N: int, sides: list[int], known: list[int]) -> tuple[Array, Array]:
    """Rows along the nominal normals of the ``known`` sides, and everything across them, on arrays that go ball after ball
    and side after side, ``(N known, 2 N sides)`` and the rest."""
    beta = scene.track.contact_angle
    along: list[Array] = []
    across: list[Array] = []
    for i in range(N):
        for k, s in enumerate(sides):
            first = 2 * (i * len(sides) + k)
            normal = np.array(SIDE_SIGNS[s]) * np.array([np.cos(beta), np.sin(beta)])
            for direction, rows in ((normal, along if s in known else across), (np.array([-normal[1], normal[0]]), across)):
                row = np.zeros(2 * N * len(sides))
                row[first : first + 2] = direction
                rows.append(row)
    return np.array(along), np.array(across)
