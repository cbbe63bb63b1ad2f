"""Contents that all pages on scenes have: table of results, text of the scene file, warnings, origin, hashes."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from rollbench.compare import __version__
from rollbench.compare.provenance import SOURCES, source_commit, sources_hash
from rollbench.compare.results.base import HEADINGS
from rollbench.compare.results.base import Row as AnswerRow
from rollbench.compare.running import package_versions
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import FREEDOMS, Scene
from rollbench.reports.cells import replace_um_by_micrometre
from rollbench.reports.content import Cell, Figure, Row, Section, Table, TableColumn, Text
from rollbench.reports.manifest import sha256

#: Libraries whose versions a page states.
LIBRARIES = ("numpy", "scipy")


def warnings_and_assumptions_section(result: StaticResult | AxisResult, warnings: Sequence[str] = ()) -> Section:
    """Return the page section that lists warnings, assumptions and neglected effects of a solution.

    ``result``: the solution. ``warnings``: further warnings, which are listed before those of the solution.
    """
    items: list[Text | Table | Figure] = []
    warned = (*warnings, *result.warnings)
    for head, lines in (("Warning", warned), ("Assumption", result.assumed), ("Neglected", result.left_out)):
        if lines:
            items.append(Text(tuple(f"{head}: {line}" for line in lines), bullets=True))
    return Section("assumptions", "Warnings, assumptions and neglected effects", items)


def results_table(rows: Sequence[AnswerRow], title: str, note: str = "", name: str = "answers") -> Table:
    """Return the page's table of results, which has the rows that ``rollbench solve`` prints.

    Parameters
    ----------
    rows
        Rows of results; each cell is a text.
    title
        Title of the table.
    note
        Sentence below the table; its first letter is capitalised.
    name
        Name of the table.

    Returns
    -------
    Table
        Table without columns in which every cell is empty.
    """
    kept = [(k, head) for k, head in enumerate(HEADINGS) if any(row[k] for row in rows)]
    forms = {"value": "g4", "error to expect": "g4"}
    quantities = [TableColumn(head, head, "", forms.get(head, "s")) for _, head in kept]
    cells: Iterator[Row] = (
        {q: replace_um_by_micrometre(row[k]) for (k, _), q in zip(kept, quantities, strict=True)} for row in rows
    )
    return Table.from_rows(name, title, cells, f"{note[:1].upper()}{note[1:]}", unfolded=True)


def rows_under_own_headings(rows: Iterable[Mapping[str, Cell]], text_heading: str) -> list[Row]:
    """Return table rows whose keys are the headings; the column ``text_heading`` has text, the others have numbers."""
    return [{TableColumn(head, head, "", "s" if head == text_heading else "g4"): row[head] for head in row} for row in rows]


def stiffness_rows(stiffness: Array, freedoms: Sequence[int] = range(6)) -> list[Row]:
    """Return table rows of a 6 x 6 stiffness, a row for each force or moment and a column for each motion.

    ``stiffness``: (6, 6) [N, m, rad]. ``freedoms``: numbers of the degrees of freedom that are shown.
    """
    return [
        {"component": FREEDOMS[i], **{("per_unit_of", FREEDOMS[k]): float(stiffness[i, k]) for k in freedoms}}
        for i in freedoms
    ]


def source_code_hash_by_name() -> dict[str, str]:
    """Return the SHA-256 of the program's source code as a dictionary; its only key is the name of this hash on pages."""
    return {SOURCES: sources_hash()}


def page_origin_facts(name: str, scene: Scene | Assembly, text: str, model: str) -> dict[str, str]:
    """Return what a page states about its origin: scene with its hash, versions, date and model, each by its label.

    Parameters
    ----------
    name
        Path of the scene file, or name of a shipped scene.
    scene
        Scene that the page shows.
    text
        TOML text of the scene.
    model
        Name of the model by which the scene is solved.
    """
    out = {
        "scene": f"{Path(name).name}, SHA-256 {sha256(text)}",
        "rollbench": f"{__version__}, commit {source_commit()}",
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "libraries": package_versions(LIBRARIES),
        "Python": f"{platform.python_version()}, {platform.system()} {platform.machine()}",
        "model": f"{model}; none of its parameters is fitted to a 3D solution",
    }
    return out | ({"source": scene.source} if scene.source else {})
