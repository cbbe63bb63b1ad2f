"""What Lin (2019) adds."""

from rollbench.comparison.registration import Part, Registration

REGISTRATION = Registration(
    parts=(
        Part("hertz", "sources.lin.sections.hertz"),
        Part("cases", "sources.lin.sections.cases", runs=True),
        Part("reconstruction", "sources.lin.sections.reconstruction", runs=True, needs=("friction", "rolling")),
        Part("errors", "sources.lin.sections.errors"),
        Part("manufacturing", "sources.lin.sections.manufacturing"),
        Part("steering", "sources.lin.sections.steering"),
        Part("friction", "sources.lin.sections.friction", needs=("friction",)),
        Part("friction-screw", "sources.lin.sections.friction_screw", needs=("friction",)),
        Part("formulations", "sources.lin.sections.formulations"),
    ),
    functions={
        "computations": "sources.lin.computations:COMPUTATIONS",
        "bench": "sources.lin.hooks:bench_jobs",
        "timing": "sources.lin.hooks:timing_tables",
        "stability": "sources.lin.hooks:stability_items",
    },
)
