"""What the wing of bearings adds: formulas that sources are computed by, and nothing of its own."""

from rollbench.comparison.registration import Registration

REGISTRATION = Registration(folders=("lowfi/bearings",))
