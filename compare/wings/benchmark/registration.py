"""What the wing of the benchmark adds."""

from rollbench.comparison.registration import Part, Registration

REGISTRATION = Registration(
    needs=("export",),
    commands={"benchmark": "wings.benchmark.arguments"},
    parts=(Part("benchmark", "wings.benchmark.section", runs=True, page="outside"),),
)
