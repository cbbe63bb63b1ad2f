"""What the wing of extreme scenes adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    needs=("sweep",),
    commands={"stability": "wings.extremes.arguments"},
    parts=(Part("stability", "wings.extremes.section", page="robustness"),),
)
