"""The twelve problems of BSCB-1: their scenes with everything that the answer depends on, and their 3D reference."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.referenced import Referenced, referenced
from rollbench.comparison.reference.store import UNSAID, shipped_store
from rollbench.comparison.reference.tasks import Solvable, meant
from rollbench.comparison.scenes import catalogue, scene_file
from rollbench.meshes.axis import Assembly
from rollbench.meshes.canonical import digest
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

NAME = "BSCB-1"
#: This folder, and that of the runs of the scenes that only the benchmark has.
HERE = Path(__file__).parent
RUNS = HERE / "runs"
#: Largest change of a contact load by another length or phase of the 3D stretch of a grooved shaft [% of the mean load]:
#: what stands for the shaft beyond it is a number of the reference, not of the problem.
JUNCTION = 0.065


@dataclass(frozen=True)
class Problem:
    """name: in files; shows: what it is there for; scene: the shipped scene that it is, or a file of this folder's
    ``scenes`` where it is named as the problem is."""

    name: str
    shows: str
    scene: str = ""

    @property
    def text(self) -> str:
        """Text of the scene as it is shipped."""
        file = HERE / "scenes" / f"{self.name}.toml"
        return catalogue.scene_text(self.scene) if self.scene else file.read_text(encoding="utf-8")

    @property
    def described(self) -> Solvable:
        """The scene, which is named as its stored runs are."""
        return _described(self)


@cache
def _described(problem: Problem) -> Solvable:
    name = problem.scene or problem.name
    found = catalogue.shipped(name) if problem.scene else scene_file.read(problem.text, f"{name}.toml")
    assert isinstance(found, Scene | Assembly)
    return found


PROBLEMS: Mapping[str, Problem] = {
    p.name: p
    for p in (
        Problem("two-balls", "two balls between rings, four-point contact, prescribed motion", "two-balls"),
        Problem("wide-ellipse", "conformities of 0.515 and 0.56: a long ellipse and a short one on one ball"),
        Problem("bearing", "four-point bearing with 12 balls, contacts on all flanks", "unseen-four-point"),
        Problem("clearance", "the same bearing with clearance: balls and flanks without contact"),
        Problem("three-balls", "three balls of a screw, two-point contact, the shortest helix", "lin-case1-cut"),
        Problem("near-face", "the last ball 1.26 ball radii before the nut's free face"),
        Problem("screw", "a screw of 32 balls in two-point contact", "lin-case1"),
        Problem("thin-nut", "a nut with a wall of 1.6 mm under the groove", "unseen-thin-nut"),
        Problem("right-face", "the nut held at its other face, balls of 32 radii", "unseen-flange"),
        Problem("hollow", "a hollow screw, preloaded by oversize", "unseen-hollow"),
        Problem("offset", "a screw bent by an offset support, four-point contact", "lin-case3-offset"),
        Problem("double-nut", "two nuts of 68 balls, preloaded against each other", "double-nut"),
    )
}


def problem(name: str) -> Problem:
    """A problem by name. Raises InputError for an unknown one."""
    if name not in PROBLEMS:
        raise InputError(NAME, "problem", name, ", ".join(PROBLEMS), "choose one of these")
    return PROBLEMS[name]


def reference_of(one: Problem) -> list[Referenced]:
    """The stored reference of a problem, set by set. Raises InputError where none is stored."""
    found = referenced(one.described, (RUNS, shipped_store()))
    if not found:
        raise InputError(NAME, one.name, "no stored run", "a 3D reference", "make it: rollbench benchmark compute")
    return found


def key_of(described: Solvable) -> str:
    """Digest of a problem's content: stored answers count for this content only."""
    bare = meant(described, UNSAID) if isinstance(described, Assembly) else replace(described, **UNSAID)
    return digest(NAME, bare)[:16]


def whole_shaft(scene: Scene) -> bool:
    """Whether the shaft goes on beyond the stretch that the reference meshes."""
    dims = dimensions(scene)
    low, high = dims.ends(scene)
    return dims.screw_held == "ends" and not all(low <= z <= high for z in scene.stations)


def fixed_text(one: Problem) -> str:
    """Text of the scene in which nothing of the solid parts is left to an assumption."""
    described = one.described
    if isinstance(described, Assembly):
        return one.text
    dims = dimensions(described)
    solid = {
        "nut_inner_diameter": 2.0 * dims.land,
        **({} if described.screw.bore > 0.0 else {"hole_diameter": 2.0 * dims.hole}),
        "shaft": dims.shaft,
    }
    lines = [f'{key} = "{1e3 * value:.10g} mm"' for key, value in solid.items()]
    lines.append(f'screw_held = "{dims.screw_held}"')
    if "held" not in tomllib.loads(one.text)["nut"]:
        lines += ["", "[nut.held]", f'at = "{dims.nut_held}"']
    without = re.sub(r"(?ms)^\[solid\]\n.*?(?=^\[|\Z)", "", one.text)
    assert "solid" not in tomllib.loads(without)
    return f"{without.rstrip()}\n\n[solid]\n" + "\n".join(lines) + "\n"
