"""Stored results of another program on a scene: what was run, on which mesh, and the contact forces it found."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.files import replace_file
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES

T = TypeVar("T")


@dataclass(frozen=True)
class BodyMesh:
    """Mesh of one body: name, nodes, cells, smallest scaled Jacobian."""

    name: str
    nodes: int
    cells: int
    smallest: float


@dataclass(frozen=True)
class CrossRun:
    """One run: choices of the deck (elements across the short half axis at mean load, growth, pressure per overclosure
    [Pa/m], weak springs [N/m], large displacements), element size at the contacts [m], digest of the deck, meshes; contact
    loads ``(n, 4)`` [N]; largest force of a weak spring on a ball [N], largest unbalanced force of a ball beyond it [N];
    iterations, last correction of the displacements [%], seconds of processor time, date, program; whether only the half at
    y >= 0 was meshed (meshes count its nodes, loads are of the whole), and whether balls have one mesh."""

    b_over_h: float
    growth: float
    stiffness: float
    spring: float
    nlgeom: bool
    fine: float
    deck: str
    meshes: tuple[BodyMesh, ...]
    load: Array
    weak: float
    unbalanced: float
    iterations: int
    correction: float
    seconds: float
    date: str
    program: str
    half: bool = False
    alike: bool = False

    @property
    def nodes(self) -> int:
        """Nodes of all bodies."""
        return sum(m.nodes for m in self.meshes)


@dataclass(frozen=True)
class CrossData:
    """All runs of one scene; key of the scene's content; version of rollbench and of gmsh that made the meshes."""

    scene: str
    key: str
    rollbench: str
    gmsh: str
    runs: tuple[CrossRun, ...]


def shipped() -> Path:
    """Folder of the results that come with the package."""
    return Path(__file__).parent


def path_of(folder: Path, scene: str) -> Path:
    """File of a scene's results."""
    return folder / f"{scene}.json"


def save(folder: Path, data: CrossData) -> Path:
    """Write a scene's results whole or not at all. Raises InputError where that fails."""
    plain = asdict(data)
    for run in plain["runs"]:
        run["load"] = [[float(f"{x:.7g}") for x in row] for row in run["load"].tolist()]
    path = path_of(folder, data.scene)
    replace_file(path, json.dumps(plain, indent=1) + "\n")
    return path


def load(folder: Path, scene: str) -> CrossData | None:
    """Results of a scene, None where there are none. Raises InputError for a damaged file."""
    found = "results that rollbench crosscheck wrote", "make them again: `run=True`"
    return read(path_of(folder, scene), lambda x: CrossData(**{**x, "runs": tuple(_run(r) for r in x["runs"])}), *found)


def read(path: Path, made: Callable[[dict[str, Any]], T], allowed: str, advice: str) -> T | None:
    """What is made of a stored JSON value, None without a file. Raises InputError for a damaged one."""
    try:
        return made(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(str(path), "file", str(error), allowed, advice) from None


def _run(plain: dict[str, Any]) -> CrossRun:
    load = np.array(plain["load"], dtype=float)
    if load.ndim != 2 or load.shape[1] != len(SIDES):
        raise ValueError(f"loads of shape {load.shape}")
    return CrossRun(**{**plain, "load": load, "meshes": tuple(BodyMesh(**m) for m in plain["meshes"])})
