"""What Lin (2019) adds."""

from rollbench.compare.registration import Part, Registration

REGISTRATION = Registration(
    title="Lin (2019)",
    needs=("evidence", "members"),
    parts=(
        Part("hertz", "sources.lin.sections.hertz", page="reference"),
        Part("cases", "sources.lin.sections.cases", quick=True, runs=True, page="cases"),
        Part(
            "reconstruction", "sources.lin.sections.reconstruction", runs=True, needs=("friction", "rolling"), page="cases"
        ),
        Part("errors", "sources.lin.sections.errors", page="tolerances"),
        Part("manufacturing", "sources.lin.sections.manufacturing", page="tolerances"),
        Part("steering", "sources.lin.sections.steering", page="friction"),
        Part("friction", "sources.lin.sections.friction", needs=("friction",), page="friction"),
        Part("friction-screw", "sources.lin.sections.friction_screw", needs=("friction",), page="friction"),
        Part("formulations", "sources.lin.sections.formulations", page="robustness"),
    ),
    functions={
        "bench": "sources.lin.hooks:bench_jobs",
        "timing": "sources.lin.hooks:timing_tables",
        "stability": "sources.lin.hooks:stability_items",
    },
)
