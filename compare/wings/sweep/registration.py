"""What the wing of sweeps adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    commands={"sweep": "wings.sweep.arguments"},
    parts=(Part("tolerances", "wings.sweep.section", page="tolerances"),),
    functions={"sweep": "wings.sweep.command:library", "bench": "wings.sweep.bench:jobs"},
)
