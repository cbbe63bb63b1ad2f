"""Model-form error to expect of a low-order result: the same model's errors against the 3D reference on scenes like it.

A scene is a point of dimensionless features; the compared scenes are points with measured errors. The estimate is the
largest error among the nearest points, grown by one part per unit of distance to the nearest one: no fit, and no number
beyond one unit, where nothing like the scene was compared. `rollbench report` writes the points (model_form.json in its
store) from the ladder.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rollbench.comparison.models.applicability import outside
from rollbench.comparison.models.registry import MODELS
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.writing import replace_file
from rollbench.lowfi.statics.problem import nominal_hertz
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

#: File of the points in a store of runs.
FILE = "model_form.json"
#: Nearest points whose largest error counts.
NEAREST = 3
#: Features with the difference that counts as one unit of distance: "like the scene" ends there.
SCALES: dict[str, tuple[str, float]] = {
    "wall": ("wall of the nut over the pitch radius", 0.1),
    "length": ("length of the nut over the pitch diameter", 0.8),
    "bore": ("bore of the screw over the pitch diameter", 0.5),
    "lead": ("lead over the pitch diameter", 0.5),
    "ball": ("ball over the pitch diameter", 0.12),
    "pressing": ("semi-axis of the contacts over the ball's radius", 0.15),
    "preload": ("loads on the second pair of flanks over those on the first", 0.6),
    "spread": ("spread of the loads over their mean", 0.5),
    "lost": ("share of the contacts about to be lost", 0.4),
    "held": ("where the nut is held", 1.0),
}
#: Fixings of the nut as a feature: any two differ by one unit.
HELD = {"left face": (0.0, 0.0), "right face": (0.0, 0.0), "both faces": (1.0, 0.0), "outer surface": (0.0, 1.0)}


@dataclass(frozen=True)
class ModelForm:
    """Model-form error to expect of a result: errors of the same model against a 3D reference on scenes like it.

    percent, rms_percent: largest and RMS error to expect, in per cent of the mean contact load; both None where nothing
    like the scene was ever compared: not covered. distance: to the nearest compared scene, 1 at the edge of what counts as
    like it; nearest: that scene; compared: how many scenes of its kind were; words: which ingredients are in, and what is
    unlike.
    """

    percent: float | None
    rms_percent: float | None
    distance: float
    nearest: str
    compared: int
    words: tuple[str, ...]


@dataclass(frozen=True)
class Point:
    """Errors of a model on one scene: largest and RMS in per cent of the mean load, the reference's own uncertainty in the
    same, and the scene's features by name."""

    scene: str
    model: str
    percent: float
    rms_percent: float
    uncertainty: float
    features: dict[str, float]


def features(scene: Scene, load: Array) -> dict[str, float]:
    """Dimensionless features of a scene with loads ``(n, 4)`` [N] of any model. Raises ValueError as `dimensions`."""
    dims, R = dimensions(scene), scene.track.pitch_radius
    both = np.sort(np.array([load[:, [0, 3]].mean(), load[:, [1, 2]].mean()]))
    main = load[:, [0, 3]] if load[:, 0].sum() >= load[:, 1].sum() else load[:, [1, 2]]
    mean = float(main.mean())
    touching = load > 0.0
    size = float(nominal_hertz(scene).C_a.mean()) * float(np.cbrt(mean))
    held = HELD[dims.nut_held]
    return {
        "wall": (scene.nut.outer_diameter / 2.0 - dims.land) / R,
        "length": scene.nut.length / (2.0 * R),
        "bore": scene.screw.bore / (2.0 * R),
        "lead": scene.track.lead / (2.0 * R),
        "ball": scene.balls.radius / R,
        "pressing": size / scene.balls.radius,
        "preload": float(both[0] / both[1]) if both[1] > 0.0 else 0.0,
        "spread": float(main.std() / mean) if mean > 0.0 else 0.0,
        "lost": float((load[touching] < 0.15 * mean).mean()) if touching.any() else 0.0,
        "held": held[0] + 2.0 * held[1],
    }


def distance(a: dict[str, float], b: dict[str, float]) -> tuple[float, str]:
    """Distance of two scenes, and the feature in which they differ most."""
    parts = {k: abs(a[k] - b[k]) / unit for k, (_, unit) in SCALES.items()}
    parts["held"] = 0.0 if a["held"] == b["held"] else 1.0
    return float(np.sqrt(sum(x * x for x in parts.values()))), max(parts, key=lambda k: parts[k])


def save_points(store: Path, points: Sequence[Point]) -> None:
    """Write the points of all models."""
    text = json.dumps([asdict(p) for p in points], indent=1, sort_keys=True) + "\n"
    replace_file(store / FILE, text)


@cache
def shipped_points() -> tuple[Point, ...]:
    """The points that come with the package; none where the file is absent or damaged."""
    try:
        rows = json.loads((shipped_store() / FILE).read_text(encoding="utf-8"))
        return tuple(Point(**row) for row in rows)
    except (OSError, ValueError, TypeError):
        return ()


def unlike_kind(scene: Scene) -> str:
    """Reason why no compared scene is of this one's kind; empty where some are (rings with a rigid screw among them)."""
    if scene.solid.nut == "rigid":
        return "its nut is rigid, that of every compared scene is elastic"
    if scene.ingredients.screw == "rigid" and scene.track.lead > 0.0:
        return "its screw is rigid, and every compared one with a lead bends"
    return ""


def estimate(scene: Scene, result: StaticResult, points: Iterable[Point] | None = None) -> ModelForm:
    """The model-form error to expect of a result, or that it is not covered by what was compared.

    Not covered: models that were not compared (Mei's), kinds of scenes that were not (rings are compared with rings only),
    scenes further than one unit from every compared one, and those beyond the range of what describes the compared ones.
    """
    model = MODELS[result.model]
    ring = scene.track.lead == 0.0
    own = [p for p in (shipped_points() if points is None else points) if p.model == (model.errors_of or model.name)]
    like = [p for p in own if (p.features["lead"] == 0.0) == ring]
    words: tuple[str, ...] = (model.words,)

    def uncovered(why: str, away: float = float("inf"), nearest: str = "") -> ModelForm:
        return ModelForm(None, None, away, nearest, len(like), (*words, why))

    try:
        here = features(scene, result.load)
    except ValueError as error:
        return uncovered(f"not comparable: {error}")
    if not own:
        return uncovered("no scene was compared with the 3D reference")
    beyond = outside(scene)
    other = unlike_kind(scene) or ("" if like else f"no {'ring' if ring else 'screw'} was compared with the 3D reference")
    if other:
        return uncovered(other)
    ordered = sorted(((*distance(here, p.features), p) for p in like), key=lambda x: x[0])
    away, unlike, nearest = ordered[0]
    if away > 1.0:
        return uncovered(f"unlike every compared scene, most in the {SCALES[unlike][0]}", away, nearest.scene)
    if beyond:
        return uncovered(f"beyond what was compared: {'; '.join(beyond)}", away, nearest.scene)
    near = [p for _, _, p in ordered[:NEAREST]]
    grow = 1.0 + away
    return ModelForm(
        grow * max(p.percent for p in near), grow * max(p.rms_percent for p in near), away, nearest.scene, len(like), words
    )
