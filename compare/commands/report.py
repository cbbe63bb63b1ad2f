"""The commands ``report``, ``view`` and ``verify``: write pages, show them, and check their hashes."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Flag, Names, Where, Word, app, engine_of
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
    """Write the validation report (HTML, tables as CSV, figures as SVG) or, with a scene, one page on it.

    Shipped runs of the 3D reference are used; one run is recomputed, and the agreement printed. Exit code 1 where it does
    not agree. What cannot be made on this machine is left out and listed at the end, with what to install. The page of a
    scene has the answers, their expected or measured error, assumptions, and the hashes of all inputs; see rollbench
    verify.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file: write one self-contained page on it, with a 3D view. The 3D reference is
        shown where runs are stored; none is computed. Several scenes: one page each, and a first page with a table of all
        answers.
    only
        Names of the sections to make. Default: all but the slow ones.
    source
        Name of a case, such as lin: make only its page, from stored runs.
    out
        Folder to write to.
    quick
        Compute the 3D reference of cases 1 and 2 on the coarsest mesh only, and make only the sections that depend on it;
        the report names those left out (printed data, errors, friction, rolling and others).
    stored
        Compute no run of the 3D reference: use the shipped ones, and leave out what they do not cover.
    store
        Folder of the computed runs of the 3D reference; an interrupted report resumes there. Shipped runs are used where
        all their inputs are unchanged.
    fresh
        Recompute all runs, even stored ones, and make all sections.
    everything
        Also make the slow sections: pictures, friction, rolling, verification, stability. Run times are those stored by
        rollbench bench --long.
    against
        Earlier report (with a scene: earlier page on it) with which to list the changes.
    reference
        With a scene: file with reference loads that replaces the 3D reference. Format: see rollbench check --reference.
    open_page
        Show the page in the browser.
    """
    if scene:
        from rollbench.compare.running import need_packages
        from rollbench.meshes.libraries import PAGES

        need_packages(*PAGES)  # some of which the next line imports
        from rollbench.compare.report.report import require_single_scene
        from rollbench.compare.report.verify import run_pages

        require_single_scene(scene, against=against, reference=reference)
        given: dict[str, Any] = {"only": only, "source": source, "quick": quick, "stored": stored, "fresh": fresh}
        given["scheduler"] = where and where.scheduler
        for name, value in given.items():
            if value:
                raise ArgumentError(name, str(value), "without a scene", "leave it out")
        return show_written_report(
            print_answer(run_pages(scene, out, store, against, reference)), out / "index.html", open_page
        )
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.report.report import make_report

    kinds: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    kinds |= {"source": source or "", "against": against}
    answer = make_report(only or (), out, store=store, engine=engine_of(where, 2), **kinds)
    return show_written_report(print_answer(answer), out / "index.html", open_page)


def show_written_report(code: int, page: Path, wanted: bool) -> int:
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
    """Show a solved scene in the browser in 3D, with the loads as colours and the values under the pointer.

    Writes one file that needs no network or server: the scene in 3D; loads, pressures and errors of every contact as
    curves, together with stored runs of the 3D reference; load cases and sets as tabs. For one set or several, of balls
    and rollers. Exit code 1 where a load case did not converge.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    out
        File to write; an earlier page is replaced.
    model
        Low-order model (see: rollbench list). Default: refined.
    member
        Number of the sample, for a scene with random errors.
    store
        Folder of stored reference runs, used in addition to the shipped runs.
    open_page
        Show the page in the browser. Default: yes.
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
    return show_written_report(code, out, open_page)


@app.command
def verify(report: Path, /, *, store: Path = Path("rollbench-reference")) -> int:
    """Verify the hashes of a scene's page or a report: its files and inputs; exit code 1 where one differs.

    Inputs are scenes, sources, printed data and reference runs.

    Parameters
    ----------
    report
        Page or folder that rollbench report wrote.
    store
        Folder of stored reference runs, used in addition to the shipped runs.
    """
    from rollbench.compare.running import need_packages
    from rollbench.meshes.libraries import PAGES

    need_packages(*PAGES)  # some of which the next line imports
    from rollbench.compare.report.verify import run_verify

    return print_answer(run_verify(report, store))
