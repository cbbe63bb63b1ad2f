"""What one scene tells of a low-order model: its errors against a run of the 3D reference.

Displacement and rigidity are those of the section of the screw that the axial load acts on.

Beyond the nut a beam and a 3D shaft agree on what a section's motion is (Saint-Venant); within it contacts move material
on their own, and a section's motion is a matter of definition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.comparison import Loads, from_result, from_run
from rollbench.compare.models.model_form import Point, features
from rollbench.compare.reference.store import Run
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import Scene

#: Scene, result of a model and run of the reference with the loads raised.
Raised = tuple[Scene, StaticResult, Run]


@dataclass(frozen=True)
class SectionAnswer:
    """Axial motion [m] of the section that the axial load acts on, and axial force [N] of the screw on the nut."""

    moved: float
    force: float


def section(scene: Scene, answer: Loads) -> SectionAnswer:
    """That of a low-order model or of a run of the 3D reference: at the largest axial load, else at the nut's centre."""
    place = max(scene.loads, key=lambda load: abs(load.force[2])).at if scene.loads else scene.nut.position
    moved = float(np.interp(place, answer.stations, answer.line[:, 2]))
    return SectionAnswer(moved, pull(scene, answer.load, np.radians(answer.angle)))


def rigidity(answers: Sequence[SectionAnswer]) -> float | None:
    """Tangent axial rigidity [N/m] between two states; None where nothing moves."""
    first, second = answers
    step = second.moved - first.moved
    return (second.force - first.force) / step if step != 0.0 else None


def pull(scene: Scene, load: Array, angle: Array) -> float:
    """Axial force [N] of the screw on the nut by loads and contact angles ``(n, 4)`` [N, rad]."""
    along = np.where(load > 0.0, load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    return float(along[0] - along[1])


def point(name: str, scene: Scene, result: StaticResult, run: Run, raised: Raised | None = None) -> Point:
    """Errors of a model's result on a scene by ``name``; raised: scene, result and run with more load, for the rigidity."""
    error = load_error(result.load, run.load, nominal_contacts(scene))
    answer, reference = section(scene, from_result(result)), section(scene, from_run(run, ""))
    stiff: tuple[float | None, float | None] = (None, None)
    if raised is not None:
        heavier, modelled, computed = raised
        stiff = (
            rigidity((answer, section(heavier, from_result(modelled)))),
            rigidity((reference, section(heavier, from_run(computed, "")))),
        )
    heaviest = run.load.max()
    return Point(
        name,
        result.model,
        round(error.max_percent, 4),
        round(error.rms_percent, 4),
        {name: round(value, 4) for name, value in features(scene, result).items()},
        off(answer.moved, reference.moved),
        off(*stiff),
        off(np.cbrt(result.load.max() / heaviest), 1.0) if heaviest > 0.0 else None,  # Hertz
        gate_percent=round(error.gate_percent, 4),
    )


def off(value: float | None, reference: float | None) -> float | None:
    """Error of a value [%]; None where either has none."""
    return None if value is None or not reference else round(float(error_percent(value, reference)), 4)
