"""What other programs, makers and textbooks add."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    title="other programs, makers, textbooks",
    needs=("evidence",),
    parts=(
        Part("external", "sources.external.section", runs=True, needs=("bearings", "friction", "rolling"), page="outside"),
        Part("holding", "sources.external.holding", runs=True, page="outside"),
    ),
    functions={"gate": "sources.external.gate:external_rows"},
)
