"""Slip and traction in the patches of some contacts, for pictures: two balls of a linear bearing, one of a ring."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rollbench.comparison.scenes.catalogue import case as shipped_case
from rollbench.comparison.scenes.kinds import KindScene
from rollbench.comparison.wings.rolling.cases import case_of
from rollbench.comparison.wings.rolling.runs import LEVELS
from rollbench.hifi.rolling.balls import Choices, ContactOut, hertz_size, solve_rolling
from rollbench.hifi.rolling.kinematics import Rolling, rolling_speed
from rollbench.meshes.arrays import Array

#: Contacts shown: scene, ball, name of the contact.
SHOWN = (("lin-pair-a", 0, "BL"), ("lin-pair-a", 0, "TR"), ("lin-rotary-1", 0, "IL"), ("lin-rotary-1", 0, "OR"))
#: Grid of the contacts.
SHAPE = LEVELS[1]


@dataclass(frozen=True)
class PatchField:
    """A contact: title, centres of cells across and along ``(n, 2)`` [m], slip over the rolling speed ``(n, 2)`` (across,
    along), tangential traction ``(n, 2)`` [Pa], which cells stick, semi-axes across and along [m]."""

    title: str
    at: Array
    slip: Array
    traction: Array
    stick: NDArray[np.bool_]
    semi: tuple[float, float]


@lru_cache(maxsize=1)
def fields() -> tuple[PatchField, ...]:
    """The contacts of `SHOWN`, balls in touch, on half spaces."""
    choices, out = Choices(SHAPE), []
    for name in dict.fromkeys(shown[0] for shown in SHOWN):
        scene = shipped_case(name, KindScene)
        case = case_of(scene, choices)
        found = solve_rolling(case.touching, choices)
        for _, ball, contact in (s for s in SHOWN if s[0] == name):
            touch = case.contacts.index(contact)
            one = next(c for c in found.contacts if (c.ball, c.touch) == (ball, touch))
            out.append(_field(f"{name}, {contact}", case.touching, one))
    return tuple(out)


def _field(title: str, scene: Rolling, one: ContactOut) -> PatchField:
    touch = scene.balls[one.ball].touches[one.touch]
    speed = rolling_speed(touch, scene)
    along, across = hertz_size(scene, touch)
    area = float(one.size.prod())
    turned = [1, 0]
    return PatchField(
        title, one.at[:, turned], one.slip[:, turned] / speed, one.tangential[:, turned] / area, one.stick, (across, along)
    )
