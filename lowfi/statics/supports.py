"""Supports of the screw as linear constraints: which of them contradict each other on a rigid screw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import FREEDOMS, Scene

#: Part of a constraint that must be new, relative to its size, for it to count as independent of those before it.
INDEPENDENT = 1e-9
#: Difference of prescribed values that counts as none, relative to the largest of them.
AGREES = 1e-9


@dataclass(frozen=True)
class Held:
    """One freedom held by a support: number of the support in the scene (from 0), freedom, its value [m or rad]."""

    support: int
    freedom: str
    value: float


@dataclass(frozen=True)
class Contradiction:
    """A held freedom that others, ``by``, already hold at another value, ``implied`` [m or rad], on a rigid screw."""

    held: Held
    implied: float
    by: tuple[Held, ...]

    def words(self, scene: Scene) -> str:
        """The contradiction in one sentence, with stations in mm."""
        names = ", ".join(f"{x.freedom} at {_station(scene, x)}" for x in self.by)
        contradicted = f"{self.held.freedom} at {_station(scene, self.held)}"
        return (
            f"the supports contradict each other on a rigid screw: {contradicted} is {show(self.held)}, but {names} "
            f"make it {show(Held(0, self.held.freedom, self.implied))}"
        )


def _station(scene: Scene, held: Held) -> str:
    return f"{1e3 * scene.supports[held.support].at:g} mm (supports[{held.support}])"


def show(held: Held) -> str:
    """Value of a held freedom with its unit: um or mrad."""
    return f"{1e6 * held.value:.6g} um" if held.freedom in FREEDOMS[:3] else f"{1e3 * held.value:.6g} mrad"


def rigid_rows(scene: Scene) -> tuple[Array, Array, list[Held]]:
    """Constraints of the supports on a rigid screw: rows ``(k, 6)`` on its motion at the nut's centre, values ``(k,)``.

    Rotations count as lengths at the pitch radius, in rows (of motions scaled so) and values [m].
    """
    arm = scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    held = [Held(i, name, value) for i, s in enumerate(scene.supports) for name, value in s.fixed]
    rows, values = np.zeros((len(held), 6)), np.zeros(len(held))
    for j, x in enumerate(held):
        k = FREEDOMS.index(x.freedom)
        rows[j] = rigid_transport(scene.supports[x.support].at - scene.nut.position)[k] * scale / scale[k]
        values[j] = x.value / scale[k]
    return rows, values, held


def contradiction(scene: Scene) -> Contradiction | None:
    """The first held freedom that the ones before it hold at another value if the screw is rigid; None where all agree."""
    rows, values, held = rigid_rows(scene)
    size = float(np.abs(values).max(initial=0.0))
    if size == 0.0:
        return None
    kept: list[int] = []
    for j in range(len(held)):
        if not kept:
            kept.append(j)
            continue
        share = np.linalg.lstsq(rows[kept].T, rows[j], rcond=None)[0]
        new = rows[j] - share @ rows[kept]
        if float(np.linalg.norm(new)) > INDEPENDENT * float(np.linalg.norm(rows[j])):
            kept.append(j)
            continue
        implied = float(share @ values[kept])
        if abs(implied - values[j]) > AGREES * size:
            by = tuple(held[k] for k, x in zip(kept, share, strict=True) if abs(x) > INDEPENDENT)
            arm = 1.0 if held[j].freedom in FREEDOMS[:3] else 1.0 / scene.track.pitch_radius
            return Contradiction(held[j], implied * arm, by)
    return None
