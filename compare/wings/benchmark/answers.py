"""The answers of BSCB-1: a row for every contact, computed from the stored runs of the 3D reference, as a CSV file.

Loads and angles are those of the finest run. Approach and pole pressure are Hertz's under that load, with the principal
curvatures of ball and flank at that angle: a program that resolves the contact finds pressures up to 2 % higher, because
ball and groove conform.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.referenced import Referenced
from rollbench.comparison.reference.estimate import Reference
from rollbench.comparison.reference.store import path_in
from rollbench.comparison.wings.benchmark.problems import (
    HERE,
    JUNCTION,
    NAME,
    PROBLEMS,
    Problem,
    key_of,
    reference_of,
    whole_shaft,
)
from rollbench.comparison.writing import replace_file
from rollbench.lowfi.statics.problem import actual_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene

COLUMNS = ("problem", "contact", "load_N", "uncertainty_N", "angle_deg", "approach_um", "pressure_MPa")
#: Columns that say what a contact is under its load.
BESIDE = COLUMNS[4:]
FILE, KEYS = "contacts.csv", "keys.json"


@dataclass(frozen=True)
class Contact:
    """Load and its uncertainty [N]; of a loaded contact its angle [deg], approach [um] and pole pressure [MPa]."""

    load: float
    uncertainty: float
    beside: Mapping[str, float]


#: Contacts of a problem by name: ball, counted over all sets, and flank, such as ``31 SL``.
Answers = Mapping[str, Contact]


def computed(one: Problem) -> tuple[dict[str, Contact], dict[str, Any]]:
    """Answers of a problem from its stored runs, and what they rest on: digest of the problem, files of the runs. Raises
    InputError where there are none."""
    found, described = reference_of(one), one.described
    out: dict[str, Contact] = {}
    for referenced in found:
        scene, ref = _parts(referenced), referenced.found
        beyond = isinstance(described, Assembly) or whole_shaft(scene)
        uncertainty = np.hypot(ref.uncertainty, 0.01 * JUNCTION * ref.mean * beyond * (ref.load > 0.0))
        beside = _beside(scene, ref)
        first = len(out) // len(SIDES)
        for i, s in np.ndindex(ref.load.shape):
            values = {name: float(x[i, s]) for name, x in beside.items()} if ref.load[i, s] > 0.0 else {}
            out[f"{first + i + 1} {SIDES[s]}"] = Contact(float(ref.load[i, s]), float(uncertainty[i, s]), values)
    # a run of several sets goes by its first: a file's name rests only on its settings
    files = [path_in(Path(), described, run).name for run in found[0].found.runs]
    return out, {"problem": key_of(described), "runs": files}


def _parts(referenced: Referenced) -> Scene:
    """The scene of a set, as its surfaces need it."""
    parts = referenced.scene if referenced.of is None else referenced.of.assembly.sets[referenced.of.number].parts
    assert isinstance(parts, Scene)
    return parts


def _beside(scene: Scene, ref: Reference) -> dict[str, Array]:
    """Angles [deg], approaches [um] and pole pressures [MPa] of the contacts ``(n, 4)``."""
    drawn, angle = specimen(scene, ball_layout(scene)), np.radians(ref.best.angle)
    gamma = np.where(np.isfinite(angle), angle, scene.track.contact_angle)
    h = actual_hertz(scene, drawn, gamma)
    return {
        "angle_deg": ref.best.angle,
        "approach_um": 1e6 * h.C * np.cbrt(ref.load) ** 2,
        "pressure_MPa": 1e-6 * h.pressure(ref.load),
    }


def table(answers: Mapping[str, Answers]) -> str:
    """The CSV file of answers of problems."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(COLUMNS)
    for name, contacts in answers.items():
        for contact, c in contacts.items():
            values = [f"{c.beside[key]:.6g}" if key in c.beside else "" for key in BESIDE]
            out.writerow([name, contact, f"{c.load:.7g}", f"{c.uncertainty:.3g}", *values])
    return text.getvalue()


def save(folder: Path) -> list[Path]:
    """Write the answers of all problems and what they rest on, from the stored runs. Raises InputError."""
    found = {name: computed(one) for name, one in PROBLEMS.items()}
    keys = {name: key for name, (_, key) in found.items()}
    replace_file(folder / FILE, table({name: contacts for name, (contacts, _) in found.items()}))
    replace_file(folder / KEYS, json.dumps(keys, indent=1) + "\n")
    return [folder / FILE, folder / KEYS]


@cache
def shipped() -> Mapping[str, Answers]:
    """The shipped answers. Raises InputError where they are of another state of a problem."""
    keys = json.loads((HERE / KEYS).read_text(encoding="utf-8"))
    for name, one in PROBLEMS.items():
        if keys.get(name, {}).get("problem") != key_of(one.described):
            advice = "make them again: rollbench benchmark compute"
            raise InputError(NAME, name, "answers of another state of the problem", "those of this state", advice)
    out: dict[str, dict[str, Contact]] = {name: {} for name in PROBLEMS}
    for row in _rows(HERE / FILE):
        beside = {key: float(row[key]) for key in BESIDE if row[key]}
        out[row["problem"]][row["contact"]] = Contact(float(row["load_N"]), float(row["uncertainty_N"]), beside)
    return out


def _rows(path: Path) -> Iterator[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def mean_load(answers: Answers) -> float:
    """Mean load of the loaded contacts of a problem [N]."""
    return float(np.mean([c.load for c in answers.values() if c.load > 0.0]))
