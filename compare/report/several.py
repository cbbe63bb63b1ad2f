"""Write the result pages of one or several scenes to a folder; for several scenes also a first page that compares them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.files import check_writable
from rollbench.compare.provenance import SOURCES
from rollbench.compare.quantities import count_with_noun, words_and_unit_of_key
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.scene_page import raise_folder_errors_as_input_errors, solve_and_make_page
from rollbench.compare.scenes import catalogue
from rollbench.reports.content import Row, Section, Table, TableColumn, text_column
from rollbench.reports.manifest import sha256
from rollbench.reports.pages import replace_report_folder
from rollbench.reports.scene_page import ScenePage, scene_page_html

#: File name of the first page.
INDEX = "index.html"
#: Keys of the groups of JSON results whose numbers the first page compares.
GROUPS = (
    "loads",
    "axial",
    "rigidities_N_per_um",
    "worst_contact",
    "static_safety",
    "preload",
    "ratings",
    "life",
    "modified_life",
    "reference_life",
    "axis_life",
    "shaft",
    "bearing_torque",
    "friction",
    "model_form",
)
#: Keys, in these groups, of numbers that are not results, such as the number of a ball.
LEFT_OUT = ("worst_ball", "ball", "compared", "distance", "allowed_over_diameter")


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
    pages = [solve_and_make_page(name, (store, shipped_store()), reference) for name in names]
    files = dict(zip([INDEX] if len(pages) == 1 else _page_file_names(names), map(scene_page_html, pages), strict=True))
    if len(pages) > 1:
        files[INDEX] = scene_page_html(scene_comparison_page(names, pages, files))

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
    scene_names: Sequence[str], pages: Sequence[ScenePage], html_by_file_name: Mapping[str, str]
) -> ScenePage:
    """Return the page that compares several scenes: the main result of each, and a table of all numerical results.

    Parameters
    ----------
    scene_names
        Names or files of the scenes.
    pages
        Page of each scene.
    html_by_file_name
        HTML text of each page, by the name of its file.
    """
    labels = [file.removesuffix(".html") for file in html_by_file_name]
    note = "A dash: no such result for this scene. Loads are contact loads; errors are expected errors."
    table = Table.from_rows(
        "answers", "Numerical results of all scenes", numerical_result_rows(labels, pages), note, unfolded=True
    )
    status = next((s for page in pages if (s := page.results["status"]) != "converged"), "converged")
    return ScenePage(
        title=f"Comparison of {count_with_noun(len(pages), 'scene')}",
        subtitle=", ".join(labels),
        verdict="",
        answers=[(label, f"{page.title}. {page.verdict}") for label, page in zip(labels, pages, strict=True)],
        picture=None,
        parts=(Section("answers", "Numerical results of the scenes side by side", (table,)),),
        provenance={label: page.provenance["scene"] for label, page in zip(labels, pages, strict=True)}
        | {key: pages[0].provenance[key] for key in ("rollbench", "date", "libraries", "Python", "model")},
        scene_text="",
        results={"status": status, "scenes": list(scene_names)},
        files={SOURCES: pages[0].files[SOURCES]} | {file: sha256(html) for file, html in html_by_file_name.items()},
        links=dict(zip(labels, html_by_file_name, strict=True)),
    )


def numerical_result_rows(column_headings: Sequence[str], pages: Sequence[ScenePage]) -> list[Row]:
    """Return the rows of the table that compares scenes: a row for each numerical result, a column for each load case.

    Parameters
    ----------
    column_headings
        Column heading of each scene; the name of a load case is appended.
    pages
        Page of each scene, which contains its results.
    """
    columns = {}
    for label, page in zip(column_headings, pages, strict=True):
        for one in page.results.get("cases", [page.results]):
            heading = f"{label}, {one['case']}" if "case" in one else label
            columns[heading] = dict(_numbers_in_results_summary({**one["summary"], "model_form": one["model_form"]}))
            lives = (page.results["summary"].get(group) for group in ("life", "reference_life") if "case" in one)
            for life in filter(None, lives):
                columns[heading] |= dict(_numbers_in_results_summary({"life": life}, "life of all cases"))
    keys = sorted(dict.fromkeys(key for column in columns.values() for key in column), key=_position_of_result_group)
    found: list[Row] = []
    for group, key in keys:
        words, unit = words_and_unit_of_key(key)
        row: Row = {
            text_column("quantity", "group of results: quantity"): f"{group}: {words}",
            text_column("unit", "unit"): unit,
        }
        found.append(row | {TableColumn(head, head): column.get((group, key)) for head, column in columns.items()})
    return found


def _position_of_result_group(key: tuple[str, str]) -> int:
    """Return the position in `GROUPS` of a result's group, by which table rows are sorted; unknown groups come last.

    ``key``: name of the group in words, and key of the result in it.
    """
    groups = [words_and_unit_of_key(group)[0] for group in GROUPS]
    return groups.index(key[0]) if key[0] in groups else len(groups)


def _numbers_in_results_summary(summary: Mapping[str, Any], group: str = "") -> Iterator[tuple[tuple[str, str], float]]:
    """Yield each number in the summary of a scene's JSON results as a pair: (name of its group, key) and value.

    The groups of results are those of `GROUPS`. ``group``: name to yield in place of the name of every group; empty: each
    group keeps its own name.
    """
    for name in GROUPS:
        table = summary.get(name)
        words, unit = words_and_unit_of_key(name)
        for key, value in table.items() if isinstance(table, dict) else ():
            if isinstance(value, int | float) and not isinstance(value, bool) and key not in LEFT_OUT:
                yield (group or words, key if not unit else f"{key}_{name.partition('_')[2]}"), value
