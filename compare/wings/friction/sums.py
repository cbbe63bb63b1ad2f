"""Sums of friction as JSON-ready values."""

from __future__ import annotations

import math
from typing import Any

from rollbench.comparison.quantities import number
from rollbench.lowfi.friction.whole.torque import ScrewTorque


def sums(t: ScrewTorque, drag: float | None) -> dict[str, Any]:
    """Torques [N mm] about +z, axial load, efficiencies; null where the scene has none."""
    screw, ideal = t.translating, t.ratio != 0.0
    forward, backward = t.efficiency
    return {
        "friction_torque_Nmm": number(1e3 * t.friction),
        "friction_torque_on_screw_Nmm": number(-math.copysign(1e3 * t.friction, t.speed)),
        "friction_torque_on_nut_Nmm": number(math.copysign(1e3 * t.friction, t.speed)),
        "drag_torque_Nmm": None if drag is None else number(1e3 * drag),
        "axial_load_N": number(t.load) if screw or not ideal else 0.0,
        "driving_torque_on_screw_Nmm": number(1e3 * t.on_screw),
        "driving_torque_on_nut_Nmm": number(-1e3 * t.on_screw),
        "load_moves": moves(t),
        "forward_torque_Nmm": number(1e3 * t.forward) if screw else None,
        "backward_torque_Nmm": number(1e3 * t.backward) if screw else None,
        "efficiency_forward_percent": percent(forward),
        "efficiency_backward_percent": None if t.locking else percent(backward),
        "self_locking": t.locking if screw else None,
    }


def moves(torque: ScrewTorque) -> str | None:
    """Whether the scene's motion goes against the axial load or with it."""
    if not torque.translating:
        return None
    return "with the load" if torque.load * torque.ratio * torque.speed > 0.0 else "against the load"


def percent(share: float) -> float | None:
    """A share in per cent."""
    return number(100.0 * share)
