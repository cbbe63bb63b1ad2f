"""Friction scenes as input for the 3D model of rolling balls: positions of balls and grooves, and contact loads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from rollbench.compare.case import brought_by_cases
from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.hifi.rolling.balls import RollingSettings
from rollbench.hifi.rolling.kinematics import RollingBalls

#: Largest number of balls that the 3D model of rolling takes.
MOST = 4


@dataclass(frozen=True)
class RollingCase:
    """Friction scene as input of the 3D model of rolling, once with balls far apart and once with touching balls."""

    #: Kind of the friction scene, such as "linear pair".
    kind: str
    #: Balls and grooves with the balls far apart.
    apart: RollingBalls
    #: The same balls and grooves with neighbouring balls that touch.
    touching: RollingBalls
    #: Speed of the part that drives the balls [m/s] on a straight track, else its angular speed [rad/s].
    speed: float
    #: Names of the contacts of each ball with the grooves.
    contact_names: tuple[str, ...]


#: Values of the balls by name, and the status.
Values: TypeAlias = tuple[dict[str, float], str]
#: Of one kind of scenes: the function that returns a scene as input of the 3D model of rolling, given the grid of the
#: contacts, and the function that returns its values by the low-order model.
RollingOfKind: TypeAlias = tuple[Callable[[Any, RollingSettings], RollingCase], Callable[[Any], Values]]


def prepare_rolling_case(scene: FrictionScene, choices: RollingSettings) -> RollingCase:
    """Return a friction scene as input of the 3D model of rolling, with its contact loads solved.

    Parameters
    ----------
    scene
        Friction scene of one to four balls.
    choices
        Grid of the contacts, on which friction is solved if the contact loads depend on friction.

    Returns
    -------
    RollingCase
        Positions, speeds and contact loads of the balls.

    Raises
    ------
    SceneNotCoveredError
        If the 3D model does not cover the scene.
    """
    makers = rolling_of_kinds()
    if scene.kind in makers:
        return makers[scene.kind][0](scene, choices)
    reason = f"the 3D model of rolling takes one to {MOST} balls under given loads, not a scene of the kind {scene.kind}"
    *kinds, last = makers
    raise SceneNotCoveredError(scene.name, "kind", reason, f"take one of the kind {', '.join(kinds)} or {last}")


def rolling_of_kinds() -> dict[str, RollingOfKind]:
    """Return, by kind of friction scene, how its scenes are solved as rolling balls: in 3D and by the low-order model."""
    return brought_by_cases("rolling")
