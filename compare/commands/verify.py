"""The command rollbench verify."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.terminal import app
from rollbench.compare.text.printing import print_answer


@app.command
def verify(report: Path, /, *, store: Path = Path("rollbench-reference")) -> int:
    """Recompute the hashes of a scene's page or of a whole report: its files, scenes, sources, printed data, reference
    runs; exit 1 where one differs.

    Parameters
    ----------
    report
        The page or folder that rollbench report wrote, with or without a scene.
    store
        Folder of the reference's runs, besides those shipped.
    """
    from rollbench.compare.running import need_packages
    from rollbench.meshes.libraries import PAGES

    need_packages(*PAGES)  # some of which the next line imports
    from rollbench.compare.report.verify import run_verify

    return print_answer(run_verify(report, store))
