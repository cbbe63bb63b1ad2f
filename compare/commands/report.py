"""Commands ``report`` and ``view``: write HTML pages, and show them in the browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from rollbench.compare.commands.terminal import (
    ComputeOptions,
    Flag,
    Names,
    Word,
    app,
    engine_from_options,
    refuse_given_arguments,
)
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import CommandOutput, print_command_output

#: Environment variables that are set if a browser window can be shown.
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
    where: ComputeOptions | None = None,
    against: Path | None = None,
    reference: Path | None = None,
    open_page: Annotated[Flag, Parameter(name="--open")] = False,
) -> int:
    """Write the validation report (HTML, tables as CSV, figures as SVG) or, if a scene is stated, a page on this scene.

    The report uses the shipped runs of the 3D reference and shipped studies. One run, and 20 or more studies that the date
    draws, are recomputed and compared with the stored ones; exit code 1 if they do not agree. Sections that cannot be
    written on this computer are listed at the end, with what to install for them. sha256sum -c SHA256SUMS, in the folder
    of the report, shows whether a file was changed. The page of a scene has the results, their expected or measured error,
    the assumptions, and the hashes of all inputs.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file, on which a self-contained page with a 3D view is written. The page shows
        stored runs of the 3D reference; none is computed. For several scenes, a page on each is written, and a first page
        with a table of all results.
    only
        Names of the sections to write. Default: all.
    source
        Name of a publication, such as lin: write only its page, from stored runs.
    out
        Folder to which the report is written.
    quick
        Compute the 3D reference of Lin's cases 1 and 2 on the coarsest mesh only, and write only the sections that depend
        on it. The report lists the omitted sections (printed data, errors, friction, rolling and others).
    stored
        Without a scene: compute no run of the 3D reference, use the shipped runs, and omit what they do not cover.
    store
        Folder of the computed runs of the 3D reference, where an interrupted report resumes. Shipped runs are used if all
        their inputs are unchanged.
    fresh
        Compute everything again: all runs, even stored ones, all sections and run times.
    against
        Earlier report (with a scene: earlier page on this scene); the new one lists what changed since then.
    reference
        With a scene: file with reference loads that replaces the 3D reference, in the format of rollbench check
        --reference.
    open_page
        Show the page in the browser.
    """
    if scene:
        from rollbench.compare.running import check_packages
        from rollbench.meshes.libraries import PAGES

        check_packages(*PAGES)  # the next line imports some of them
        from rollbench.compare.report.changes import write_and_compare_pages
        from rollbench.compare.report.report import refuse_unusable_scene_arguments

        refuse_unusable_scene_arguments(scene, against=against, reference=reference)
        given: dict[str, Any] = {"only": only, "source": source, "quick": quick, "stored": stored, "fresh": fresh}
        given["scheduler"] = where and where.scheduler
        refuse_given_arguments(given, "only for a report without a scene", "leave it out")
        code = print_command_output(write_and_compare_pages(scene, out, store, against, reference))
        return open_written_page(code, out / "index.html", open_page)
    if reference is not None:
        raise ArgumentError("reference", str(reference), "only together with a scene", "state the scene of these loads")
    from rollbench.compare.report.report import write_validation_report

    kinds: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh}
    kinds |= {"source": source or "", "against": against}
    answer = write_validation_report(only or (), out, store=store, engine=engine_from_options(where, 2), **kinds)
    return open_written_page(print_command_output(answer), out / "index.html", open_page)


def open_written_page(code: int, page: Path, wanted: bool) -> int:
    """Show a written page in the browser if the user wants it, and return the exit code ``code`` unchanged.

    If the computer has no browser or no screen, a printed line says so. ``wanted``: whether to show the page.
    """
    if wanted:
        screen = os.name == "nt" or sys.platform == "darwin" or any(map(os.environ.get, SCREENS))
        if not (screen and webbrowser.open(page.resolve().as_uri())):
            line = "no browser was found on this computer: open the page in any other browser"
            print_command_output(CommandOutput(texts_and_tables=[line]))
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
    """Solve a scene and show it in 3D in the browser, with the contact loads as colours and the values under the pointer.

    Writes one HTML file that needs no network or server. It shows the scene in 3D, and the loads, pressures and errors of
    every contact as curves, together with stored runs of the 3D reference. Load cases, nuts and bearings are on separate
    tabs. Exit code 1 if a load case did not converge.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    out
        File to write; a page that this command wrote earlier is replaced.
    model
        Low-order model (rollbench list shows all). Default: refined.
    member
        Number of the specimen, from 0, in a scene with random errors.
    store
        Folder of stored runs of the reference, used in addition to the shipped runs.
    open_page
        Show the page in the browser. Default: yes.
    """
    from rollbench.compare.api.calls import solve_scene_record
    from rollbench.compare.errors import SceneNotCoveredError
    from rollbench.compare.files import check_writable, replace_file
    from rollbench.compare.models.model import ModelOptions
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.reports.view import MARKER

    if out.is_file() and MARKER not in out.read_text(encoding="utf-8", errors="replace"):
        allowed = "a new file, or a page that rollbench report wrote earlier"
        raise ArgumentError("out", f"the existing file {out}", allowed, "choose another name")
    check_writable(out)
    described, options = catalogue.scene_of_any_kind(scene), ModelOptions(member=member)
    found = solve_scene_record(described, model, options, name_for_messages=scene)
    try:
        html = found.view_page((store, shipped_store()))
    except ValueError:
        advice = "correct the scene as the reason says"
        raise SceneNotCoveredError(scene, "scene", found.reason or str(found.status), advice) from None
    replace_file(out, html)
    answer = CommandOutput(texts_and_tables=[*found._notes, f"page: {out}"], exit_code=int(not found.converged))
    return open_written_page(print_command_output(answer), out, open_page)
