"""What pages on scenes share: table of answers, text of the file, notes, provenance, hashes."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Iterator, Sequence
from pathlib import Path

from rollbench.compare import __version__
from rollbench.compare.provenance import SOURCES, commit, sources_hash
from rollbench.compare.results.base import HEADINGS
from rollbench.compare.results.base import Row as AnswerRow
from rollbench.compare.running import package_versions
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.reports.cells import micro_sign
from rollbench.reports.content import Figure, Quantity, Row, Section, Table, Text
from rollbench.reports.manifest import sha256

LIBRARIES = ("numpy", "scipy", "numba")


def scene_text(name: str) -> str:
    """Return the text of a scene file or of a shipped scene."""
    return catalogue.scene_text(name) if name in catalogue.scene_names() else scene_file.read_text(name)


def notes_section(result: StaticResult | AxisResult, warnings: Sequence[str] = ()) -> Section:
    """Return the section of warnings, assumptions and neglected effects."""
    items: list[Text | Table | Figure] = []
    warned = (*warnings, *result.warnings)
    for head, lines in (("Warning", warned), ("Assumed", result.assumed), ("Left out", result.left_out)):
        if lines:
            items.append(Text(tuple(f"{head}: {line}" for line in lines), bullets=True))
    return Section("assumptions", "Assumptions", items)


def answers_table(rows: Sequence[AnswerRow], title: str, note: str = "") -> Table:
    """Return the table of answers with the rows that ``rollbench solve`` prints.

    Parameters
    ----------
    rows
        Rows of results.
    title
        Title of the table.
    note
        Sentence below the table; its first letter is capitalised.

    Returns
    -------
    Table
        The table, without columns that have no text.
    """
    kept = [(k, head) for k, head in enumerate(HEADINGS) if any(row[k] for row in rows)]
    forms = {"value": "g4", "error to expect": "g4"}
    quantities = [Quantity(head, head, "", forms.get(head, "s")) for _, head in kept]
    cells: Iterator[Row] = ({q: micro_sign(row[k]) for (k, _), q in zip(kept, quantities, strict=True)} for row in rows)
    return Table.of("answers", title, cells, f"{note[:1].upper()}{note[1:]}", unfolded=True)


def source_files() -> dict[str, str]:
    """Return the SHA-256 of the program's sources, by name."""
    return {SOURCES: sources_hash()}


def page_provenance(name: str, scene: Scene | Assembly, text: str, model: str) -> dict[str, str]:
    """Return the provenance of a page: scene with its hash, versions, date and model."""
    out = {
        "scene": f"{Path(name).name}, SHA-256 {sha256(text)}",
        "rollbench": f"{__version__}, commit {commit()}",
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "libraries": package_versions(LIBRARIES),
        "Python": f"{platform.python_version()}, {platform.system()} {platform.machine()}",
        "model": f"{model}; nothing in it is fitted to a 3D solution",
    }
    return out | ({"source": scene.source} if scene.source else {})
