"""Mesh levels of the 3D reference and of rolling contacts; each level refines all settings of the previous one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rollbench.compare import files

#: Ball radius [m] for which the lengths in the settings are stated; for other radii they are scaled in proportion.
BALL = 2.778e-3
_TABLES = files.shipped_table("reference/levels.toml")


def _settings(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return mesh settings read from a TOML table, with its lists as tuples."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in keys.items()}


#: Mesh settings (`hifi.meshing.part_meshes.Settings`) of each level, coarse to fine; lengths in m. b_over_h counts
#: second-order cells, so that there are twice as many nodes. From one level to the next, the cells at the contact are
#: refined by 4/3. The following are refined by 1.15 to 1.2: cells and sockets of the submodels for a contact's local
#: compliance, coarse bodies and balls, which only transfer loads between contacts, and the models of the shaft's cut ends.
#: The growth of the patches' cells and the numbers of modes follow. The plane mesh of the shaft's cross-section is the same
#: on all levels; its error is below 0.04 % in bending (tests/unit/hifi/test_helical_section.py).
LEVELS: dict[int, dict[str, Any]] = {int(level): _settings(keys) for level, keys in _TABLES["level"].items()}
#: Finer values of single settings of the finest level (`compare.reference.variants`).
BEYOND: dict[str, Any] = _settings(_TABLES["beyond"])
#: Level 0 is the mesh of Lin's thesis: first-order tetrahedra, 0.08 mm around every contact, 5 mm elsewhere (made of split
#: second-order ones of twice the size). It is not part of a convergence study.
SOURCE_LEVEL = 0
SOURCE_MESH: dict[str, Any] = _settings(_TABLES["source"])
#: Finest level of a production run; variants refine single settings of it.
PRODUCTION = 3
#: Levels of a mesh study. The last one is finer than a production run and tests the uncertainty estimated from the others.
#: Level 5 does the same for scenes with lightly loaded contacts next to heavily loaded ones, from four levels.
STUDIED = (1, 2, 3, 4)
#: Default levels of a scene outside the studies: level 3 is more accurate than level 1 by a factor of 1.8, measured on all
#: scenes that were solved on three levels or more. Between consecutive levels the factors are 1.6, 1.2 and 1.2, because the
#: error due to the cut of the coarse sockets is the same on all levels (tests/unit/models/test_grid_coverage.py).
ADVISED = (1, 3)
#: Kinds of bodies in models of rolling contacts.
HALF_SPACE, FINITE = "half-space", "finite"
_RATIOS = ("b_over_h", "growth")


def scaled(level: int, ball: float, refined: Sequence[str] = ()) -> dict[str, Any]:
    """Return the mesh settings of a level, with lengths scaled to a ball radius [m].

    ``refined``: names of settings whose finer values are used (`BEYOND`).
    """
    ratio = ball / BALL
    settings = dict(SOURCE_MESH if level == SOURCE_LEVEL else LEVELS[level]) | {name: BEYOND[name] for name in refined}

    def for_ball(name: str, value: Any) -> Any:
        if isinstance(value, float) and name not in _RATIOS:
            return value * ratio
        return tuple(x * ratio for x in value) if name.endswith("sizes") else value

    return {name: for_ball(name, value) for name, value in settings.items()}
