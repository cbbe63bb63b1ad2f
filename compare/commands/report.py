"""The commands ``report``, ``view`` and ``verify``: pages written and shown, and their hashes computed again."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Names, Where, Word, app, engine
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import Answer, print_answer

#: Variables that say where a window can be shown, or by what.
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


@app.command
def report(
    *scene: str,
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
    open_page: Annotated[Flag, Parameter(name="--open")] = False,
) -> int:
    """Regenerate the validation report: HTML, its tables as CSV, its figures as SVG; with a scene: one page on it.

    Shipped runs of the 3D reference are used; one is recomputed, and the agreement printed. What cannot be made on this
    machine is left out and named at the end, with what to install. Exit code 1 where the run recomputed does not agree.
    The page of a scene carries the answers, the error to expect or measured, assumptions, and the hashes of all that it
    rests on; see rollbench verify.

    Parameters
    ----------
    scene
        A shipped name or a scene file: write one self-contained page on it instead, on which the scene can be turned. The
        3D reference is set beside it where runs are stored; none is computed. Several: a page on each, and a first page
        with a table of all answers side by side.
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
    open_page
        Show the page in the browser.
    """
    if scene:
        from rollbench.compare.running import need_packages
        from rollbench.meshes.libraries import PAGES

        need_packages(*PAGES)  # some of which the next line imports
        from rollbench.compare.report.report import one_scene
        from rollbench.compare.report.verify import run_pages

        one_scene(scene, against=against, reference=reference)
        given: dict[str, Any] = {"only": only, "source": source, "quick": quick, "stored": stored, "fresh": fresh}
        given["scheduler"] = where and where.scheduler
        for name, value in given.items():
            if value:
                raise ArgumentError(name, str(value), "without a scene", "leave it out")
        return shown(print_answer(run_pages(scene, out, store, against, reference)), out / "index.html", open_page)
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.report.report import make_report

    kinds: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    kinds |= {"source": source or "", "against": against}
    answer = make_report(only or (), out, store=store, engine=engine(where, 2), **kinds)
    return shown(print_answer(answer), out / "index.html", open_page)


def shown(code: int, page: Path, wanted: bool) -> int:
    """Show a page in the browser if it is wanted; return the exit code."""
    if wanted:
        screen = os.name == "nt" or sys.platform == "darwin" or any(map(os.environ.get, SCREENS))
        if not (screen and webbrowser.open(page.resolve().as_uri())):
            print_answer(Answer(parts=["no browser was found here: open the page by its name, on any machine"]))
    return code


@app.command
def view(
    scene: str,
    /,
    *,
    out: Path = Path("rollbench-view.html"),
    model: Word = "",
    member: int = 0,
    store: Path = Path("rollbench-reference"),
    open_page: Annotated[bool, Parameter(name="--open", negative="--no-open", show_default=False)] = True,
) -> int:
    """Look at a solved scene in the browser: turn it, with the loads as colours and values under the pointer.

    Writes one file that holds all it needs, without network or server: the scene in 3D; loads, pressures and errors of
    every contact as curves, beside runs of the 3D reference where they are stored; load cases and sets as tabs. Of one set
    or several, of balls and rollers. Exit code 1 where a load case did not converge.

    Parameters
    ----------
    scene
        A shipped name or a scene file.
    out
        File to write; an earlier page is replaced.
    model
        refined unless given; see: rollbench list.
    member
        Number of the specimen, for a scene with random errors.
    store
        Folder of the reference's runs, besides those shipped.
    open_page
        Show it in the browser, which it is unless --no-open is given.
    """
    from rollbench.compare.api.calls import solve_described
    from rollbench.compare.errors import Refusal
    from rollbench.compare.files import need_writable, replace_file
    from rollbench.compare.models.registry import Options
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.reports.view import MARKER

    if out.is_file() and MARKER not in out.read_text(encoding="utf-8", errors="replace"):
        raise ArgumentError("out", str(out), "a new file or an earlier page", "choose another name")
    need_writable(out)
    found = solve_described(catalogue.any_scene(scene), model, Options(member=member), origin=scene)
    try:
        html = found.view_page((store, shipped_store()))
    except ValueError:
        raise Refusal(scene, "scene", found.reason or str(found.status), "see: rollbench solve") from None
    replace_file(out, html)
    code = print_answer(Answer(parts=[*found._notes, f"page: {out}"], code=int(not found.converged)))
    return shown(code, out, open_page)


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
