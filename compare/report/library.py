"""`rollbench.report`: the report as the library writes it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.api.calls import LOG
from rollbench.compare.errors import ArgumentError
from rollbench.compare.results.base import JSON
from rollbench.compare.results.data import Written
from rollbench.meshes.threads import held_to_one_thread


@held_to_one_thread()
def report(
    scene: str | Path | None = None,
    *,
    only: Sequence[str] = (),
    out: str | Path = "rollbench-report",
    store: str | Path = "rollbench-reference",
    reference: str | Path | None = None,
    quick: bool = False,
    stored: bool = False,
    fresh: bool = False,
    everything: bool = False,
) -> Written:
    """The validation report, or one page on a scene (a name or file), written to the folder ``out``.

    only, quick, stored, fresh, everything: of the whole report, as the command's options (everything: ``--all``);
    reference: of a page, your own in place of the 3D reference.
    Raises InputError, Refusal where the scene does not solve.
    """
    folder = Path(out)
    choices = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    given = [name for name, value in choices.items() if value]
    if scene is not None and given:
        raise ArgumentError(given[0], "given", "without a scene", "leave it out")
    index = folder / "index.html"
    if scene is not None:
        from rollbench.compare.report.scene_page import make_page

        page = make_page(str(scene), folder, Path(store), None if reference is None else Path(reference))
        warned = tuple(f"WARNING: {warning}" for warning in page.warnings)
        data: dict[str, JSON] = {"page": str(index), "passed": True, "verdict": page.verdict}
        return Written(data, "", (*warned, page.verdict), page=index, passed=True, verdict=page.verdict)
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.report.report import make_report

    how: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    answer = make_report(only, folder, store=Path(store), say=LOG.info, **how)
    passed = answer.code == 0
    return Written({"page": str(index), "passed": passed}, "", tuple(map(str, answer.parts)), page=index, passed=passed)
