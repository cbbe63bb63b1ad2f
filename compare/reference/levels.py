"""Mesh levels of the 3D reference and of rolling contacts; a level refines all numerical settings together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rollbench.compare import files

#: Ball radius [m] for which the lengths of the levels are stated; for other radii they are scaled in proportion.
BALL = 2.778e-3
_TABLES = files.shipped_table("reference/levels.toml")


def _settings(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings from TOML with lists as tuples."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in keys.items()}


#: Settings (`hifi.meshing.part_meshes.Settings`) by level, coarse to fine; lengths in m. b_over_h counts second-order
#: cells, so there are twice as many nodes. From level to level cells at the contact are refined by 4/3; cells and sockets
#: of the submodels that say what a contact answers by itself, coarse bodies and balls, which only carry loads from contact
#: to contact, and those that say what the shaft's cut ends do by 1.15 to 1.2; the growth of patches' cells, modes and
#: balls' modes with them. The plane mesh of the shaft's section is the same on all: within 0.04 % in bending
#: (tests/unit/hifi/test_helical_section.py).
LEVELS: dict[int, dict[str, Any]] = {int(level): _settings(keys) for level, keys in _TABLES["level"].items()}
#: Settings that refine single choices of the finest level (`compare.reference.variants`).
BEYOND: dict[str, Any] = _settings(_TABLES["beyond"])
#: Level 0 is the source's mesh: first-order tetrahedra, 0.08 mm around every contact, 5 mm elsewhere (second-order ones of
#: twice the size, split); no part of a convergence study.
SOURCE_LEVEL = 0
SOURCE_MESH: dict[str, Any] = _settings(_TABLES["source"])
#: Finest level of a production run; variants refine single settings of it.
PRODUCTION = 3
#: Levels of a study: the last, beyond production, judges the uncertainty of those before it. Level 5 is for scenes with
#: lightly loaded contacts next to heavily loaded ones, where it judges the uncertainty of four levels.
STUDIED = (1, 2, 3, 4)
#: Default levels of a scene outside the studies: level 3 is more accurate than level 1 by a factor of 1.8, measured on all
#: scenes that were solved on three levels or more. From level to level the factors are 1.6, 1.2 and 1.2: what the cut of
#: the coarse sockets leaves is on all levels the same (tests/unit/models/test_grid_coverage.py).
ADVISED = (1, 3)
#: Bodies under rolling contacts.
HALF_SPACE, FINITE = "half-space", "finite"
_RATIOS = ("b_over_h", "growth")


def scaled(level: int, ball: float, refined: Sequence[str] = ()) -> dict[str, Any]:
    """Return the mesh settings of a level for a ball radius [m]; ``refined``: names of settings from ``BEYOND``."""
    ratio = ball / BALL
    settings = dict(SOURCE_MESH if level == SOURCE_LEVEL else LEVELS[level]) | {name: BEYOND[name] for name in refined}

    def for_ball(name: str, value: Any) -> Any:
        if isinstance(value, float) and name not in _RATIOS:
            return value * ratio
        return tuple(x * ratio for x in value) if name.endswith("sizes") else value

    return {name: for_ball(name, value) for name, value in settings.items()}
