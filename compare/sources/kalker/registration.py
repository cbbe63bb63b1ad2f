"""What Kalker's table adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    title="Kalker (1990)",
    needs=("evidence", "rolling"),
    parts=(
        Part(
            "rolling",
            "sources.kalker.section",
            meshed="no motion against the static reference, sizes of bodies",
            needs=("bearings", "external"),
            page="rolling",
        ),
    ),
)
