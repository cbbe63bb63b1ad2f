"""`rollbench.report`: the report as the library writes it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rollbench.compare.api.calls import LOG
from rollbench.compare.errors import InputError
from rollbench.compare.results.base import JSON
from rollbench.compare.results.data import Data
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
) -> Data:
    """The validation report, or one page on a scene (a name or file), written to the folder ``out``.

    only, quick, stored, fresh, everything: of the whole report, as the command's options (everything: ``--all``);
    reference: of a page, your own in place of the 3D reference.
    ``["passed"]`` of the result is False where a run of the reference that was recomputed does not agree with the stored
    one. Raises InputError, Refusal where the scene does not solve.
    """
    folder = Path(out)
    choices = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    given = [name for name, value in choices.items() if value]
    if scene is not None and given:
        raise InputError("report", given[0], "given", "without a scene", "leave it out")
    data: dict[str, JSON] = {"page": str(folder / "index.html"), "passed": True}
    if scene is not None:
        from rollbench.compare.commands.reporting.scene_page import make_page

        page = make_page(str(scene), folder, Path(store), None if reference is None else Path(reference))
        warned = tuple(f"WARNING: {warning}" for warning in page.warnings)
        return Data(data | {"verdict": page.verdict}, "", (*warned, page.verdict))
    if reference is not None:
        raise InputError("report", "reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.commands.reporting.report import make_report

    how = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    answer = make_report(only, folder, store=Path(store), say=LOG.info, **how)
    data["passed"] = answer.code == 0
    return Data(data, "", tuple(map(str, answer.parts)))
