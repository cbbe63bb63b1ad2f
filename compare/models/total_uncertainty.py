"""What a comparison with the 3D reference is uncertain by in all, part by part, and what no part holds.

Parts of the contact loads, in per cent of the mean load, independent and so added by squares: discretisation
(`compare.reference.grid_parts`), modelling choices that no mesh shows (`compare.models.modelling`, kept as a record of the
scenes on which they were varied), tolerances of the inputs (`compare.models.u_val`), and the second order of displacements,
which the reference leaves out: CalculiX finds contacts of the scene two-balls weaker by large displacements in proportion
to their larger semi-axis a over the ball radius r, dF / F = -`SECOND_ORDER` a / r, within 15 %.

Beside them stands what all contacts of a screw share whose sum of loads equilibrium does not hold: independent 3D programs
find that sum larger by `SHARED`, with one sign, while finer meshes of the reference move it by less and the other way.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.answers import load_answers
from rollbench.compare.models.applicability import outside
from rollbench.compare.models.modelling import SPOKEN_FOR, Modelling
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import Study
from rollbench.compare.models.u_val import QUANTITIES, SENSITIVE, input_parts
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.grid_parts import both_flanks
from rollbench.compare.reference.grid_summary import uncertainty_percent
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.writing import replace_file
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Scene

#: Record of the modelling choices, beside the stored runs.
FILE = "choices.json"
#: Relative loss of load by large displacements over a / r [-] (tests/unit/models/test_total_uncertainty.py).
SECOND_ORDER = 0.030
#: Sums of independent 3D programs over the reference's, preloaded scenes, least and largest [%].
SHARED = (0.12, 0.19)


@dataclass(frozen=True)
class Choices:
    """Modelling choices varied on a scene: largest change of a contact load by all together [% of the mean load], the one
    that changes most, and by how much."""

    scene: str
    percent: float
    choice: str
    alone: float


@dataclass(frozen=True)
class Total:
    """Uncertainty of a scene's contact loads [% of the mean load] by part (None: not known): discretisation and whether it
    is from experience alone; modelling choices, the one that dominates, the scene on which they were varied; inputs and the
    one that dominates; second order of displacements; whether the sum of loads has the part that all contacts share;
    stated: of a user's own reference what that says, which is all that is known; of the discretisation, what the contact
    ``at_face`` has by a free face of the nut (`compare.reference.near_face`)."""

    discretisation: float
    by_experience: bool
    choices: Choices | None
    inputs: float | None
    input: str
    second_order: float
    shared: bool
    stated: str = ""
    beside_face: float = 0.0
    at_face: str = ""

    @property
    def percent(self) -> float:
        """All parts, by the root of the sum of squares."""
        modelling = 0.0 if self.choices is None else self.choices.percent
        return float(np.linalg.norm([self.discretisation, modelling, self.inputs or 0.0, self.second_order]))

    @property
    def text(self) -> str:
        """All and by part, in words."""
        if self.stated:
            return self.stated
        grid = f"discretisation {self.discretisation:.2f} %{' by experience with other scenes' * self.by_experience}"
        if self.at_face:
            grid += f", of it {self.beside_face:.2f} % at {self.at_face} beside the nut's free face"
        c = self.choices
        modelling = "modelling choices not known" if c is None else f"modelling choices {c.percent:.2f} %, most {c.choice}"
        inputs = (
            "inputs not known"
            if self.inputs is None
            else f"inputs {self.inputs:.2f} %, most {self.input.partition(',')[0]}"
        )
        second = f"large displacements {self.second_order:.2f} %"
        return f"uncertain by {self.percent:.2f} % in all: {grid}; {modelling}; {inputs}; {second}"

    @property
    def beside(self) -> str:
        """What no part holds, as a sentence; empty where the sum of loads is held by equilibrium."""
        if not self.shared:
            return ""
        low, high = SHARED
        return (
            f"Beside it, for all contacts alike: independent 3D programs find sums of preloaded screws {low:g} to {high:g} "
            "% larger than the 3D reference; no mesh shows it, no bar holds it."
        )

    def as_json(self) -> dict[str, Any]:
        """JSON-ready."""
        c = self.choices
        return {
            "total_percent": self.percent,
            "discretisation_percent": None if self.stated else self.discretisation,
            "discretisation_by_experience": self.by_experience,
            "beside_free_face_percent": self.beside_face,
            "beside_free_face_at": self.at_face or None,
            "modelling_percent": None if c is None else c.percent,
            "modelling_dominated_by": None if c is None else c.choice,
            "modelling_varied_on": None if c is None else c.scene,
            "input_percent": self.inputs,
            "input_dominated_by": self.input or None,
            "large_displacements_percent": self.second_order,
            "shared_by_all_percent": list(SHARED) if self.shared else None,
        }


def total(scene: Scene, reference: Reference, *, inputs: bool = True) -> Total:
    """The uncertainty of a scene's reference; inputs: whether that by the tolerances of the inputs is looked for."""
    if reference.stated:
        return Total(uncertainty_percent(reference), False, None, None, "", 0.0, False, reference.stated)
    share, name = _inputs(scene) if inputs else (None, "")
    lip, at = beside_face(reference)
    return Total(
        uncertainty_percent(reference),
        reference.parts.by_experience,
        spoken_for(replace(scene, name=reference.best.scene), read(shipped_store())),
        share,
        name,
        second_order(scene, reference),
        both_flanks(reference.load),
        beside_face=lip,
        at_face=at,
    )


def beside_face(reference: Reference) -> tuple[float, str]:
    """Largest part of a contact's uncertainty that is by a free face beside it [% of the mean load], and the contact; none
    where it is less than what discretisation leaves uncertain in all."""
    share = np.zeros(1) if reference.beside_face is None else error_percent(reference.beside_face, 0.0, reference.mean)
    if share.max() <= reference.parts.bar or not reference.parts.bar:
        return 0.0, ""
    ball, side = np.unravel_index(int(share.argmax()), share.shape)
    return float(share.max()), f"ball {ball + 1} {SIDES[side]}"


def second_order(scene: Scene, reference: Reference) -> float:
    """What large displacements take from the most loaded contact [% of the mean load]."""
    worst = load_answers(scene, reference.load, np.radians(reference.best.angle)).worst
    if worst is None:
        return 0.0
    lost = SECOND_ORDER * worst.a / scene.balls.radius * worst.force
    return float(error_percent(lost, 0.0, mean_load(reference.load)))


def _inputs(scene: Scene) -> tuple[float | None, str]:
    """Largest effect [%] of the tolerances of the inputs on a contact's load, and the one that has most of it."""
    study = Study()
    if not MODELS[SENSITIVE].suits(scene) or not study.solve(scene, SENSITIVE).converged:
        return None, ""
    parts = input_parts(study, scene, QUANTITIES[0])
    largest = float(np.sqrt(sum(change**2 for change in parts.values())).max())
    return largest, max(parts, key=lambda name: float(np.abs(parts[name]).max()))


def choices_of(varied: Modelling) -> Choices:
    """The record of choices that were varied on a scene."""
    first = max(varied.choices, key=lambda name: varied.choices[name])
    return Choices(varied.scene, varied.largest, first, varied.choices[first])


def spoken_for(scene: Scene, known: Mapping[str, Choices]) -> Choices | None:
    """The choices that speak for a scene: of its own parts, or else the ones with the largest effect; none for a scene
    beyond what was compared. Raises ValueError as `applicability.outside`."""
    if outside(scene):
        return None
    return known.get(SPOKEN_FOR.get(scene.name, "")) or max(known.values(), key=lambda c: c.percent, default=None)


def save(store: Path, known: Mapping[str, Choices]) -> None:
    """Write the record of a store. Raises OSError where that cannot be done."""
    replace_file(store / FILE, json.dumps({name: asdict(c) for name, c in known.items()}, indent=1) + "\n")


@cache
def read(store: Path) -> dict[str, Choices]:
    """The record of a store. Raises OSError, ValueError or TypeError without a whole one."""
    return {name: Choices(**fields) for name, fields in json.loads((store / FILE).read_text(encoding="utf-8")).items()}
