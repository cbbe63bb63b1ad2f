"""What Liu et al. (2025) add."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    title="Liu et al. (2025)",
    needs=("evidence", "random_errors"),
    parts=(Part("liu", "sources.liu.section", page="sources"),),
    functions={
        "bench": "sources.liu.bench:jobs",
        "timing jobs": "sources.liu.bench:jobs",
        "references": "sources.liu.evidence.bodies:references",
    },
)
