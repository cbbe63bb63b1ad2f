"""What the wing of CalculiX adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    needs=("export",),
    commands={"crosscheck": "wings.crosscheck.arguments"},
    parts=(Part("crosscheck", "wings.crosscheck.section", runs=True, meshes=True, page="reference"),),
    functions={
        "deck": "wings.crosscheck.export_deck:run",
        "other program": "wings.crosscheck.study:extrapolated",
        "references": "wings.crosscheck.study:references",
    },
)
