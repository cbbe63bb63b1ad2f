"""What the wing of run times adds."""

from rollbench.comparison.registration import Part, Registration

REGISTRATION = Registration(
    commands={"bench": "wings.bench.arguments"},
    parts=(Part("timing", "wings.bench.section", alone=True, page="robustness"),),
)
