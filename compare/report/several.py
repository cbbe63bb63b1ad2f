"""Write the result pages of one or several scenes to a folder; for several scenes also a first page that compares them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from rollbench.compare.files import check_writable
from rollbench.compare.provenance import SOURCES
from rollbench.compare.quantities import count_with_noun
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.scene_page import raise_folder_errors_as_input_errors, solve_and_make_page
from rollbench.compare.results.side_by_side import SideBySide, compare_results_side_by_side
from rollbench.compare.results.solved import Result
from rollbench.compare.scenes import catalogue
from rollbench.compare.text.solved import number_or_range_text
from rollbench.reports.content import Item, Row, Section, Table, TableColumn
from rollbench.reports.manifest import sha256
from rollbench.reports.pages import replace_report_folder
from rollbench.reports.scene_html import ScenePage, scene_page_html

#: File name of the first page.
INDEX = "index.html"


def write_scene_pages(names: Sequence[str], out: Path, store: Path, reference: Path | None = None) -> list[ScenePage]:
    """Solve scenes by the default model and write a page for each; for several scenes also a page that compares them.

    All scenes are read before the first is solved, and nothing is written before all are solved.

    Parameters
    ----------
    names
        Names or files of scenes.
    out
        Folder in which the pages are written.
    store
        Folder with stored runs of the 3D reference, used besides the shipped runs.
    reference
        File with contact loads that replaces the 3D reference, for a single scene.

    Returns
    -------
    list of ScenePage
        Page of each scene.

    Raises
    ------
    InputError
        For a scene that cannot be shown, or a folder that contains other files. If a scene has no solution, the subclass
        SceneNotCoveredError.
    """
    for name in names:
        catalogue.scene_of_any_kind(name)
    with raise_folder_errors_as_input_errors(out):
        check_writable(out / INDEX)
    solved = [solve_and_make_page(name, (store, shipped_store()), reference) for name in names]
    pages = [page for page, _ in solved]
    files = dict(zip([INDEX] if len(pages) == 1 else _page_file_names(names), map(scene_page_html, pages), strict=True))
    if len(pages) > 1:
        files[INDEX] = scene_page_html(scene_comparison_page(names, pages, [found for _, found in solved], files))

    def write(folder: Path) -> None:
        for name, html in files.items():
            (folder / name).write_text(html, encoding="utf-8", newline="\n")

    with raise_folder_errors_as_input_errors(out):
        replace_report_folder(out, write)
    return pages


def _page_file_names(scene_names: Sequence[str]) -> list[str]:
    """Return the file names of the scenes' pages, made of the scenes' names; equal names get a number appended."""
    files = [INDEX]
    for name in scene_names:
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", Path(name).stem).strip("-.") or "scene"
        taken, count = {file.lower() for file in files}, 1
        while (file := f"{stem}{f'-{count}' if count > 1 else ''}.html").lower() in taken:
            count += 1
        files.append(file)
    return files[1:]


def scene_comparison_page(
    scene_names: Sequence[str], pages: Sequence[ScenePage], results: Sequence[Result], html_by_file_name: Mapping[str, str]
) -> ScenePage:
    """Return the page that compares several scenes: the main result of each, and all results side by side.

    Parameters
    ----------
    scene_names
        Names or files of the scenes.
    pages, results
        Page and results of each scene.
    html_by_file_name
        HTML text of each page, by the name of its file.
    """
    labels = [file.removesuffix(".html") for file in html_by_file_name]
    each = [
        (", ".join(filter(None, (label, case))), one)
        for label, found in zip(labels, results, strict=True)
        for case, one in (found.cases or {"": found}).items()
    ]
    both = compare_results_side_by_side([one for _, one in each], [name for name, _ in each])
    figure = both.figure()
    items: list[Item] = [side_by_side_table(both), *([] if figure is None else [figure])]
    return ScenePage(
        title=f"Comparison of {count_with_noun(len(pages), 'scene')}",
        subtitle=", ".join(labels),
        verdict="",
        answers=[(label, f"{page.title}. {page.verdict}") for label, page in zip(labels, pages, strict=True)],
        picture=None,
        parts=(Section("answers", "Results of the scenes side by side", items),),
        provenance={label: page.provenance["scene"] for label, page in zip(labels, pages, strict=True)}
        | {key: pages[0].provenance[key] for key in ("rollbench", "date", "libraries", "Python", "model")},
        scene_text="",
        results={
            "status": "converged" if both.converged else next(x.status for x in both.scenes if x.status != "converged"),
            "scenes": list(scene_names),
        },
        files={SOURCES: pages[0].files[SOURCES]} | {file: sha256(html) for file, html in html_by_file_name.items()},
        links=dict(zip(labels, html_by_file_name, strict=True)),
    )


def side_by_side_table(both: SideBySide) -> Table:
    """Return the table of all results of several scenes, with differences from the first scene in per cent."""
    rows = list[Row]()
    for key, one in both.numbers.items():
        row: Row = {"quantity": one.label, "unit": one.unit or ""}
        for k, (scene, off) in enumerate(zip(both.scenes, both.difference_percent(key), strict=True)):
            name = scene.scene
            row[TableColumn(name, name, "", "s")] = number_or_range_text(one.value(scene))
            if k:
                row[TableColumn(f"{name}_percent", f"{name}, from {both.scenes[0].scene}", "%", "+.1f")] = off
        rows.append(row)
    inputs = both.inputs_in_words.capitalize()
    note = f"{inputs}. Life of a load case: if only this case acted. A dash: no such result for this scene."
    return Table.from_rows("answers", "Results of all scenes", rows, note, unfolded=True)
