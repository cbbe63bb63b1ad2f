"""What a mesh level leaves out of a contact's compliance beside a free face of the nut, and what its load is wrong by.

A contact's own compliance is that of a finely meshed piece of its body (`hifi.bodies.coarse`), far from any face. Beside
a free face a lip gives way besides, as the cells of the level's body have it, which are too stiff: nuts of six balls,
solved alone with ever finer bodies, say by how much (``near_face.json``, written by ``tests/near_face.py``). In terms of
1 / (E r) the missing compliance is the same for balls and leads of all sizes within a quarter, and depends on the distance
d from the face over the ball radius r: on level 1 it is 0.4 at d = 1.1 r and 0.03 at 2.5 r.

It concerns the flank that is pressed towards the face, and through its ball the screw's opposite flank. At a given approach
of the bodies a missing compliance dC makes their load F too large by

    dF = F dC / (2/3 (delta_s + delta_n) / F + C_lip),

delta: Hertz's approaches, whose tangent is 2/3 delta / F. Held faces, and balls away from faces, have none. Where one flank
of the screw carries load, equilibrium holds the sum of loads, and what these contacts have too much the others of their
side have too little, in proportion to their own stiffness (`left_out`). The changes between a scene's own levels show that,
and of a ring, all of whose contacts are beside both faces, the rest as well (`compare.reference.grid_parts`).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rollbench.compare.reference.grid_parts import STIFFNESS, both_flanks
from rollbench.compare.reference.store import shipped_store
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

FILE = "near_face.json"
#: Distance [ball radii] from which on a face is not near: linear to nothing from the last one measured.
AWAY = 3.0
#: How far it goes on growing before the nearest one measured [ball radii]; no socket finds room nearer to a face.
CLOSER = 0.25
#: Approach [m] below which there is no load.
TINY = 1e-30
#: Flank of the nut that is pressed towards its low face, and towards its high one.
TOWARDS = (2, 3)


@dataclass(frozen=True)
class Lip:
    """Distances [ball radii] of contacts from a free face, rising; times Young's modulus and the ball's radius, the
    compliance of the lip before them, and what of it a level leaves out, by level."""

    radii: Array
    lip: Array
    missing: dict[int, Array]

    def at(self, radii: Array, level: int) -> tuple[Array, Array]:
        """Compliance of the lip and what is missing on a level (beyond the last one measured: as on that)."""
        missing = self.missing[min(max(level, 1), max(self.missing))]
        return np.interp(radii, self.radii, self.lip), np.interp(radii, self.radii, missing)


@cache
def read(store: Path) -> Lip:
    """The record of a store: the scene that is measured on all levels, what is missing there raised by the largest ratio
    that any other scene has to it; nearer to the face by the two nearest distances, further away down to nothing. Raises
    OSError, ValueError or KeyError without a whole one."""
    rows = json.loads((store / FILE).read_text(encoding="utf-8"))
    first = [row for row in rows if row["scene"] == rows[0]["scene"]]
    radii = np.array([row["radii"] for row in first])
    step = CLOSER / (radii[1] - radii[0])

    def ended(values: list[float]) -> Array:
        return np.array([values[0] + step * (values[0] - values[1]), *values, 0.0])

    missing = {int(k): [row["missing"][k] for row in first] for k in first[0]["missing"]}
    spread = max(row["missing"]["1"] / np.interp(row["radii"], radii, missing[1]) for row in rows)
    places = np.array([radii[0] - CLOSER, *radii, AWAY])
    return Lip(places, ended([row["lip"] for row in first]), {k: spread * ended(values) for k, values in missing.items()})


def too_large(scene: Scene, load: Array, level: int) -> Array:
    """What contact loads ``(n, 4)`` [N] of a level are too large by at most beside free faces of the nut ``(n, 4)`` [N]."""
    from rollbench.hifi.meshing.settings import hertz_units

    out = np.zeros_like(load)
    if scene.solid.nut != "elastic" or scene.track.lead == 0.0:
        return out
    r, held = scene.balls.radius, dimensions(scene).nut_held
    z, half = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0
    soft = [2.0 / 3.0 * unit.approach for unit in hertz_units(scene)]
    known, unit = read(shipped_store()), 1.0 / (scene.nut.material.youngs_modulus * r)
    for side, face, away in ((TOWARDS[0], "left face", half + z), (TOWARDS[1], "right face", half - z)):
        if held in (face, "both faces"):
            continue
        lip, missing = (unit * x for x in known.at(away / r, level))
        for flank in (side, 3 - side):
            force = load[:, flank]
            springs = (soft[side] + soft[3 - side]) * np.cbrt(force) ** 2  # force times their tangent
            added = force**2 * missing / np.maximum(springs + lip * force, TINY)
            out[:, flank] = np.maximum(out[:, flank], added)
    return out


def left_out(scene: Scene, load: Array, level: int) -> Array:
    """What contact loads ``(n, 4)`` [N] of a level are wrong by at most, because contacts beside free faces have too much:
    these, and where equilibrium holds the sum of loads the others of their side ``(n, 4)`` [N]."""
    excess = too_large(scene, load, level)
    if both_flanks(load) or not excess.any():
        return excess
    stiffness = load**STIFFNESS
    return np.asarray(excess + excess.sum(axis=0) * stiffness / np.maximum(stiffness.sum(axis=0), TINY))
