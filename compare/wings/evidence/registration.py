"""What the wing of evidence adds: printed numbers beside what is computed for them."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    commands={"audit": "wings.evidence.arguments"},
    parts=(
        Part("notes", "wings.evidence.sections.notes", quick=True, runs=True, page="trust"),
        Part("verdicts", "wings.evidence.sections.verdicts", runs=True, page="entries"),
        Part("audit", "wings.evidence.sections.audit", runs=True, page="entries"),
    ),
    functions={"gate of what is printed": "wings.evidence.gate:printed_rows", "traces": "wings.evidence.command:traced"},
)
