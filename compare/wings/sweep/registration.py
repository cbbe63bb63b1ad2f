"""What the wing of sweeps adds."""

from rollbench.compare.case import Part
from rollbench.compare.registration import Registration

REGISTRATION = Registration(
    commands={"sweep": "wings.sweep.arguments"},
    parts=(Part("tolerances", "wings.sweep.section", page="tolerances"),),
    functions={"sweep": "wings.sweep.command:library", "bench": "wings.sweep.bench:jobs"},
)
