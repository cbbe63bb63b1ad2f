"""Writing pages on scenes to a folder: of one scene its page, of several also a table of their results."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.files import need_writable
from rollbench.compare.provenance import SOURCES
from rollbench.compare.quantities import count_of, split_unit
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.scene_page import make_page, writing_to_folder
from rollbench.compare.scenes import catalogue
from rollbench.reports.content import Quantity, Row, Section, Table
from rollbench.reports.manifest import sha256
from rollbench.reports.pages import replace_folder
from rollbench.reports.scene_page import ScenePage, render_page

INDEX = "index.html"
#: Tables of the JSON whose numbers are shown side by side.
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
#: Numbers of these that are no results.
LEFT_OUT = ("worst_ball", "ball", "compared", "distance", "allowed_over_diameter")


def make_pages(names: Sequence[str], out: Path, store: Path, reference: Path | None = None) -> list[ScenePage]:
    """Solve scenes by the default model and write a page for each, with a first page of all if there are several.

    All scenes are read before the first is solved, and nothing is written before all are.

    Parameters
    ----------
    names
        Names or files of scenes.
    out
        Folder to write.
    store
        Folder with runs of the 3D reference, besides those shipped.
    reference
        File with loads instead of the 3D reference, for one scene.

    Returns
    -------
    list of ScenePage
        The pages.

    Raises
    ------
    InputError
        For a scene of another kind and a folder with other files; as Refusal if a scene does not solve.
    """
    for name in names:
        catalogue.any_scene(name)
    with writing_to_folder(out):
        need_writable(out / INDEX)
    pages = [make_page(name, (store, shipped_store()), reference) for name in names]
    files = dict(zip([INDEX] if len(pages) == 1 else _page_file_names(names), map(render_page, pages), strict=True))
    if len(pages) > 1:
        files[INDEX] = render_page(side_by_side(names, pages, files))

    def write(folder: Path) -> None:
        for name, html in files.items():
            (folder / name).write_text(html, encoding="utf-8", newline="\n")

    with writing_to_folder(out):
        replace_folder(out, write)
    return pages


def _page_file_names(names: Sequence[str]) -> list[str]:
    """Return a file name for each scene; of equal names the later ones are numbered."""
    files = [INDEX]
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", Path(name).stem).strip("-.") or "scene"
        taken, count = {file.lower() for file in files}, 1
        while (file := f"{stem}{f'-{count}' if count > 1 else ''}.html").lower() in taken:
            count += 1
        files.append(file)
    return files[1:]


def side_by_side(names: Sequence[str], pages: Sequence[ScenePage], files: Mapping[str, str]) -> ScenePage:
    """Return the first page of several scenes: their results and a table; ``files``: page file by scene."""
    labels = [file.removesuffix(".html") for file in files]
    note = "A dash: the scene has no such answer. Loads are those of contacts; errors are those to be expected."
    table = Table.of("answers", "Every number that the scenes answer", number_rows(labels, pages), note, unfolded=True)
    status = next((s for page in pages if (s := page.results["status"]) != "converged"), "converged")
    return ScenePage(
        title=f"{count_of(len(pages), 'scene')} side by side",
        subtitle=", ".join(labels),
        verdict="",
        answers=[(label, f"{page.title}. {page.verdict}") for label, page in zip(labels, pages, strict=True)],
        picture=None,
        parts=(Section("answers", "Side by side", (table,)),),
        provenance={label: page.provenance["scene"] for label, page in zip(labels, pages, strict=True)}
        | {key: pages[0].provenance[key] for key in ("rollbench", "date", "libraries", "Python", "model")},
        scene_text="",
        results={"status": status, "scenes": list(names)},
        files={SOURCES: pages[0].files[SOURCES]} | {file: sha256(html) for file, html in files.items()},
        links=dict(zip(labels, files, strict=True)),
    )


def number_rows(labels: Sequence[str], pages: Sequence[ScenePage]) -> list[Row]:
    """Return a row for each number, with a column for each scene or each of its load cases."""
    columns = {}
    for label, page in zip(labels, pages, strict=True):
        for one in page.results.get("cases", [page.results]):
            heading = f"{label}, {one['case']}" if "case" in one else label
            columns[heading] = dict(_numbers_of_summary({**one["summary"], "model_form": one["model_form"]}))
            if "case" in one and (life := page.results["summary"].get("life")):
                columns[heading] |= dict(_numbers_of_summary({"life": life}, "life of all cases"))
    keys = sorted(dict.fromkeys(key for column in columns.values() for key in column), key=_group_rank)
    found: list[Row] = []
    for group, key in keys:
        words, unit = split_unit(key)
        row: Row = {Quantity("quantity", "quantity", "", "s"): f"{group}: {words}", Quantity("unit", "unit", "", "s"): unit}
        found.append(row | {Quantity(head, head): column.get((group, key)) for head, column in columns.items()})
    return found


def _group_rank(key: tuple[str, str]) -> int:
    """Return the sort rank of a row's group; rows within a group keep their order."""
    groups = [split_unit(group)[0] for group in GROUPS]
    return groups.index(key[0]) if key[0] in groups else len(groups)


def _numbers_of_summary(summary: Mapping[str, Any], group: str = "") -> Iterator[tuple[tuple[str, str], float]]:
    """Yield the numbers of a summary, with the name of their group and their key."""
    for name in GROUPS:
        table = summary.get(name)
        words, unit = split_unit(name)
        for key, value in table.items() if isinstance(table, dict) else ():
            if isinstance(value, int | float) and not isinstance(value, bool) and key not in LEFT_OUT:
                yield (group or words, key if not unit else f"{key}_{name.partition('_')[2]}"), value
