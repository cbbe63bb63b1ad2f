"""Options and help of ``rollbench bench``."""

from __future__ import annotations

from rollbench.comparison.commands.arguments.terminal import Json, app
from rollbench.comparison.commands.printing import print_answer


@app.command
def bench(*, as_json: Json = False) -> int:
    """Measure run times as ratios to the source's formulation in the same process."""
    from rollbench.comparison.wings.bench.command import run_bench_command

    return print_answer(run_bench_command(), as_json)
