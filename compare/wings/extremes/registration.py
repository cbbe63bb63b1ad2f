"""What the wing of extreme scenes adds."""

from rollbench.compare.case import Part
from rollbench.compare.registration import Registration

REGISTRATION = Registration(
    needs=("sweep",),
    commands={"stability": "wings.extremes.arguments"},
    parts=(Part("stability", "wings.extremes.section", page="robustness"),),
)
