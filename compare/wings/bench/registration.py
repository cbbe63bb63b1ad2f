"""What the wing of run times adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    needs=("members",),
    commands={"bench": "wings.bench.arguments"},
    parts=(
        Part("overview", "wings.bench.sections.overview", quick=True, runs=True, page="accuracy"),
        Part("timing", "wings.bench.section", page="robustness"),
    ),
    functions={"run times": "wings.bench.sections.reference_time:time_items"},
)
