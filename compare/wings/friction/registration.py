"""What the wing of friction adds."""

from rollbench.compare.registration import Registration

#: Kinds of scenes that only friction solves.
KINDS = ("bearing ball", "bearing pair", "linear pair", "linear chain", "screw pair", "screw run")
REGISTRATION = Registration(
    folders=("lowfi/friction",),
    commands={"friction": "wings.friction.arguments"},
    kinds=dict.fromkeys(KINDS, "wings.friction.kinds.table:KINDS"),
    functions={
        "friction": "wings.friction.quick:quick_friction",
        "friction of a scene": "wings.friction.solve:library",
        "friction of a page": "wings.friction.page:section",
        "circuit faults": "wings.friction.quick:circuit_faults",
        "torque": "wings.friction.quick:torque",
    },
)
