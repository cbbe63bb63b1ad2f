"""The commands ``report`` and ``verify``: pages written, and their hashes computed again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Names, Where, app, engine
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import print_answer


@app.command
def report(
    scene: str | None = None,
    /,
    *,
    only: Names = None,
    source: str | None = None,
    out: Path = Path("rollbench-report"),
    quick: Flag = False,
    stored: Flag = False,
    store: Path = Path("rollbench-reference"),
    fresh: Flag = False,
    everything: Annotated[Flag, Parameter(name="--all")] = False,
    where: Where | None = None,
    against: Path | None = None,
    reference: Path | None = None,
) -> int:
    """Regenerate the validation report: HTML, its tables as CSV, its figures as SVG; with a scene: one page on it.

    Shipped runs of the 3D reference are used; one is recomputed, and the agreement printed. What cannot be made on this
    machine is left out and named at the end, with what to install. Exit code 1 where the run recomputed does not agree.
    The page of a scene carries the answers, the error to expect or measured, assumptions, and the hashes of all that it
    rests on; see rollbench verify.

    Parameters
    ----------
    scene
        A shipped name or a scene file: write one self-contained page on it instead. The 3D reference is set beside it where
        runs are stored; none is computed.
    only
        Names of the sections to make; all but the costly ones unless given.
    source
        Name of a case, such as lin: make its page alone, from stored runs.
    out
        Folder to write to.
    quick
        Compute the 3D reference of cases 1 and 2 on the coarsest mesh only, and make the sections that rest on it; what
        sources printed, errors, friction, rolling and the rest are left out, and the report names them.
    stored
        Compute no run of the 3D reference: use those that come with the package, and leave out what they do not hold.
    store
        Folder of the runs of the 3D reference that are computed; an interrupted report resumes there. Runs of the
        package are used where the key of all that they depend on holds.
    fresh
        Recompute all runs, whatever is stored, and make all sections.
    everything
        Also make the slow sections: pictures, friction, rolling, verification, stability. Run times are those that
        rollbench bench --long measured and kept.
    against
        An earlier report, or with a scene an earlier page on it, to list what moved.
    reference
        With a scene: your own reference in place of the 3D reference, as for rollbench check.
    """
    if scene is not None:
        from rollbench.compare.running import need_packages
        from rollbench.meshes.libraries import PAGES

        need_packages(*PAGES)  # some of which the next line imports
        from rollbench.compare.report.verify import run_page

        given: dict[str, Any] = {"only": only, "source": source, "quick": quick, "stored": stored, "fresh": fresh}
        given["scheduler"] = where and where.scheduler
        for name, value in given.items():
            if value:
                raise ArgumentError(name, str(value), "without a scene", "leave it out")
        return print_answer(run_page(scene, out, store, against, reference))
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.report.report import make_report

    kinds: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    kinds |= {"source": source or "", "against": against}
    return print_answer(make_report(only or (), out, store=store, engine=engine(where, 2), **kinds))


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
