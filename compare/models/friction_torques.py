"""Record of the friction torques and efficiencies of a screw, bearing or shaft, and their keys in JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rollbench.compare.quantities import quantities_of_instance
from rollbench.meshes.quantity import quantity_or_none, result_record

#: Keys of the torques of one screw or bearing, in the order of the JSON.
TORQUE_KEYS = (
    "friction_torque_Nmm",
    "friction_torque_on_screw_Nmm",
    "friction_torque_on_nut_Nmm",
    "reverse_friction_torque_Nmm",
    "drag_torque_Nmm",
    "axial_load_N",
    "driving_torque_on_screw_Nmm",
    "driving_torque_on_nut_Nmm",
    "load_moves",
    "forward_torque_Nmm",
    "backward_torque_Nmm",
    "efficiency_forward_percent",
    "efficiency_backward_percent",
    "self_locking",
)


def fraction_in_percent(fraction: float | None) -> float | None:
    """Return a fraction [1] in per cent; None if it is not known."""
    return None if fraction is None else 100.0 * fraction


@result_record(eq=False, repr=False, kw_only=True)
class FrictionTorques:
    """Friction and driving torques [N m] about +z of a screw, bearing or shaft, its axial load [N] and efficiencies [1].

    A field is None if the quantity does not exist for the part, such as the efficiency of a bearing, or is not known.
    """

    torque: float | None = quantity_or_none(
        "torque.friction_torque_Nmm",
        "torque of the friction forces only; it opposes the motion",
        error="proportional to the coefficient",
        heading="friction torque",
        form="g3",
    )
    reverse_torque: float | None = quantity_or_none(
        "torque.reverse_friction_torque_Nmm",
        "torque of the friction forces in the reversed motion",
        error="that of the friction torque",
        heading="friction torque, reversed",
        form="g3",
    )
    torque_on_screw: float | None = quantity_or_none(
        "torque.friction_torque_on_screw_Nmm",
        "friction torque that acts on the screw, with sign",
        error="that of the friction torque",
    )
    torque_on_nut: float | None = quantity_or_none(
        "torque.friction_torque_on_nut_Nmm",
        "friction torque that acts on the nut, with sign",
        error="that of the friction torque",
    )
    drag_torque: float | None = quantity_or_none(
        "torque.drag_torque_Nmm",
        "friction torque without the scene's external loads, from the preload only",
        error="proportional to the coefficient",
        heading="drag torque",
        form="g3",
    )
    axial_load: float | None = quantity_or_none("torque.axial_load_N", "axial load against which the torque works")
    driving_torque_on_screw: float | None = quantity_or_none(
        "torque.driving_torque_on_screw_Nmm",
        "torque that drives the screw in the stated motion",
        error="friction's share of it",
    )
    driving_torque_on_nut: float | None = quantity_or_none(
        "torque.driving_torque_on_nut_Nmm",
        "torque that drives the nut in the stated motion",
        error="friction's share of it",
    )
    load_moves: str | None = quantity_or_none("torque.load_moves", "whether the motion is with or against the axial load")
    forward_torque: float | None = quantity_or_none(
        "torque.forward_torque_Nmm",
        "torque that moves the nut against the axial load: F l/(2 pi) + friction",
        error="friction's share of it",
        heading="torque against the load",
        form="g3",
    )
    backward_torque: float | None = quantity_or_none(
        "torque.backward_torque_Nmm",
        "torque that the axial load delivers when it drives the screw: F l/(2 pi) - friction",
        error="friction's share of it",
        heading="torque with the load",
        form="g3",
    )
    efficiency_forward: float | None = quantity_or_none(
        "torque.efficiency_forward_percent",
        "work done on the axial load, divided by the work of the driving torque",
        error="1 - efficiency is proportional to the coefficient",
        heading="efficiency against the load",
        form="g3",
        show=fraction_in_percent,
    )
    efficiency_backward: float | None = quantity_or_none(
        "torque.efficiency_backward_percent",
        "work of the torque that the screw delivers, divided by the work of the axial load",
        error="1 - efficiency is proportional to the coefficient",
        heading="efficiency with the load",
        form="g3",
        show=fraction_in_percent,
    )
    self_locking: bool | None = quantity_or_none(
        "torque.self_locking", "whether the screw is self-locking: the axial load cannot turn it", heading="self-locking"
    )

    def torques_as_json(self, keys: Sequence[str] = TORQUE_KEYS) -> dict[str, Any]:
        """Return those torques and efficiencies that ``keys`` name as JSON, in this order."""
        known = quantities_of_instance(self)
        return {key: known[f"torque.{key}"].value(self) for key in keys}
