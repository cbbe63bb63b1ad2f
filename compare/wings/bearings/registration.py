"""What the wing of bearings adds: formulas that sources are computed by, and what makers print of pairs."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(
    folders=("lowfi/bearings",),
    functions={"conformity": "wings.bearings.pairs:conformity", "starting torque": "wings.bearings.pairs:starting_torque"},
)
