"""Mesh levels of the 3D reference: every numerical choice, refined together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

#: Ball radius [m] to which the levels' lengths belong; other scenes in proportion.
BALL = 2.778e-3
#: Settings (`hifi.meshing.fit.Settings`) by level, coarse to fine; lengths in m. b_over_h counts second-order cells, so
#: there are twice as many nodes. From level to level cells at the contact are refined by 4/3; cells and sockets of the
#: submodels that say what a contact answers by itself, coarse bodies and balls, which only carry loads from contact to
#: contact, and those that say what the shaft's cut ends do by 1.15 to 1.2; the growth of patches' cells, modes and balls'
#: modes with them. The plane mesh of the shaft's section is the same on all: within 0.04 % in bending
#: (tests/unit/hifi/test_helical_section.py).
LEVELS: dict[int, dict[str, Any]] = {
    1: {
        "b_over_h": 1.8,
        "growth": 1.9,
        "own_cuts": (4, 4, 4),
        "own_sizes": (0.60e-3, 3.6e-3),
        "own_ball_sizes": (0.33e-3, 0.75e-3),
        "fine": 1.5e-3,
        "coarse": 7.5e-3,
        "cuts": (3, 2, 3),
        "modes": 10,
        "ball_fine": 0.44e-3,
        "ball_coarse": 0.98e-3,
        "ball_modes": 10,
        "cell": 5.0e-3,
    },
    2: {
        "b_over_h": 2.4,
        "growth": 1.75,
        "own_cuts": (5, 5, 5),
        "own_sizes": (0.50e-3, 3.1e-3),
        "own_ball_sizes": (0.27e-3, 0.65e-3),
        "fine": 1.3e-3,
        "coarse": 6.5e-3,
        "cuts": (3, 2, 3),
        "modes": 12,
        "ball_fine": 0.36e-3,
        "ball_coarse": 0.80e-3,
        "ball_modes": 12,
        "cell": 4.3e-3,
    },
    3: {
        "b_over_h": 3.2,
        "growth": 1.62,
        "own_cuts": (6, 6, 6),
        "own_sizes": (0.42e-3, 2.7e-3),
        "own_ball_sizes": (0.23e-3, 0.56e-3),
        "fine": 1.15e-3,
        "coarse": 5.7e-3,
        "cuts": (3, 2, 3),
        "modes": 14,
        "ball_fine": 0.30e-3,
        "ball_coarse": 0.66e-3,
        "ball_modes": 14,
        "cell": 3.7e-3,
    },
    4: {
        "b_over_h": 4.25,
        "growth": 1.5,
        "own_cuts": (7, 7, 7),
        "own_sizes": (0.36e-3, 2.35e-3),
        "own_ball_sizes": (0.20e-3, 0.48e-3),
        "fine": 1.0e-3,
        "coarse": 5.0e-3,
        "cuts": (3, 2, 3),
        "modes": 16,
        "ball_fine": 0.25e-3,
        "ball_coarse": 0.56e-3,
        "ball_modes": 16,
        "cell": 3.2e-3,
    },
    5: {
        "b_over_h": 5.65,
        "growth": 1.4,
        "own_cuts": (8, 8, 8),
        "own_sizes": (0.31e-3, 2.05e-3),
        "own_ball_sizes": (0.17e-3, 0.41e-3),
        "fine": 0.87e-3,
        "coarse": 4.4e-3,
        "cuts": (3, 2, 3),
        "modes": 18,
        "ball_fine": 0.21e-3,
        "ball_coarse": 0.48e-3,
        "ball_modes": 18,
        "cell": 2.8e-3,
    },
}
#: Settings by which single choices of the finest level are refined alone (`compare.reference.variants`).
BEYOND: dict[str, Any] = {
    "b_over_h": 4.2,
    "growth": 1.5,
    "own_cuts": (8, 7, 8),
    "own_sizes": (0.35e-3, 2.3e-3),
    "own_ball_sizes": (0.19e-3, 0.48e-3),
    "fine": 1.0e-3,
    "coarse": 5.0e-3,
    "cuts": (4, 3, 4),
    "modes": 28,
    "ball_fine": 0.25e-3,
    "ball_coarse": 0.55e-3,
    "ball_modes": 28,
    "cell": 3.1e-3,
}
#: Level 0 is the source's mesh: first-order tetrahedra, 0.08 mm around every contact, 5 mm elsewhere (second-order ones of
#: twice the size, split); no part of a convergence study.
SOURCE_LEVEL = 0
SOURCE_MESH: dict[str, Any] = {
    "b_over_h": 0.8,
    "fine": 1.6e-3,
    "coarse": 10.0e-3,
    "ball_fine": 0.55e-3,
    "ball_coarse": 1.3e-3,
    "cell": 5.0e-3,
    "tet": 0.08e-3,
    "cuts": (2, 2, 2),
    "modes": 16,
    "ball_modes": 1000,
}
#: Finest level of a production run, from which single choices are refined alone.
PRODUCTION = 3
#: Levels of a study: the one beyond production judges the uncertainty of those before it. Level 5 is for scenes with
#: lightly loaded contacts beside heavy ones, of which it judges that of four levels.
STUDIED = (1, 2, 3, 4)
#: Levels of a scene that nobody studies: each is clearly more accurate than those before it, which level 3 hardly is than
#: levels 1 and 2 (`rollbench mesh-study`).
ADVISED = (1, 2, 4)
_RATIOS = ("b_over_h", "growth")


def scaled(level: int, ball: float, refined: Sequence[str] = ()) -> dict[str, Any]:
    """Settings of a level for a ball radius [m]; ``refined``: names taken from ``BEYOND``."""
    ratio = ball / BALL
    settings = dict(SOURCE_MESH if level == SOURCE_LEVEL else LEVELS[level]) | {name: BEYOND[name] for name in refined}

    def own(name: str, value: Any) -> Any:
        if isinstance(value, float) and name not in _RATIOS:
            return value * ratio
        return tuple(x * ratio for x in value) if name.endswith("sizes") else value

    return {name: own(name, value) for name, value in settings.items()}
