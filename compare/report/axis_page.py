"""``rollbench report SCENE`` of several sets on a shaft: the page on one load case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from rollbench.compare.errors import Refusal
from rollbench.compare.models.answers import AxisAnswers
from rollbench.compare.models.load_cases import SolvedAxis
from rollbench.compare.report.parts import answers_table, notes_section, page_provenance, scene_text, source_files
from rollbench.compare.results.rows import answer_rows, expected_words, set_rows
from rollbench.compare.results.scene_json import ball_rows_of_axis, case_json, roller_rows
from rollbench.compare.results.view import make_view
from rollbench.lowfi.rating.contacts import RACES
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.parts import FREEDOMS, SIDES
from rollbench.reports.content import Quantity, Row, Section, Table
from rollbench.reports.scene_page import ScenePage


def page_of_axis(name: str, one: SolvedAxis, stores: Sequence[Path]) -> ScenePage:
    """Return the page of several solved sets on a shaft.

    Parameters
    ----------
    name
        Path of the scene file, or name of a shipped scene.
    one
        The solved shaft.
    stores
        Folders with runs of the 3D reference.

    Returns
    -------
    ScenePage
        The page.

    Raises
    ------
    Refusal
        If the scene has no solution.
    """
    scene, result = one.scene, one.result
    if one.answers is None:
        raise Refusal(name, "scene", result.status, "see: rollbench solve")
    text, data = scene_text(name), case_json(one)
    parts = [Section("sets", "Sets", _sets_table(one)), Section("loads", "Loads and pressures", [*_contacts_table(result)])]
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure and life by rollbench, model {result.model}",
        verdict_sentence(result, one.answers),
        (),
        None,
        (*parts, notes_section(result)),
        page_provenance(name, scene, text, result.model),
        text,
        data,
        source_files(),
        view=make_view(scene.title, [one], data, (), stores),
        table=answers_table(answer_rows(one), f"Answers of model {result.model}", expected_words(None)),
    )


def verdict_sentence(result: AxisResult, answers: AxisAnswers) -> str:
    """Return one sentence on the contact with the highest pressure relative to its limit, of all sets.

    Parameters
    ----------
    result
        Solution of the shaft.
    answers
        Its answers.

    Returns
    -------
    str
        Load [N], pressure [MPa] and static safety of this contact, or that no contact carries load.
    """
    if not answers.by_pressure:
        return "No contact carries load."
    k = answers.by_pressure[0]
    worst, safety = answers.sets[k].loads.worst, answers.sets[k].loads.safety
    assert worst is not None
    assert safety is not None
    return (
        f"The most pressed contact, in {result.sets[k].of.name}, carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {safety.factor:.2g}; no error of several sets is estimated."
    )


def _sets_table(one: SolvedAxis) -> list[Table]:
    """Return the table of the sets and, if computed, that of the stiffness of the whole shaft."""
    result = one.result
    rows: list[Row] = [
        {Quantity(head, head, "", "s" if head == "set" else "g4"): text for head, text in row.items()}
        for row in set_rows(one)
    ]
    tables = [Table.of("sets", "Force on the shaft, and stiffness of each set alone", rows)]
    if result.stiffness is not None:
        cells: list[Row] = []
        for freedom, line in zip(FREEDOMS, result.stiffness, strict=True):
            cell: Row = {Quantity("freedom", "force or moment", "", "s"): freedom}
            cell |= {Quantity(f, f): None if np.isnan(x) else float(x) for f, x in zip(FREEDOMS, line, strict=True)}
            cells.append(cell)
        note = f"{result.stiffness_at}, tangent; a dash: held; rows and columns in N, N m, m and rad."
        tables.append(Table.of("tangent", "Stiffness 6 x 6 of the whole", cells, note))
    return tables


def _contacts_table(result: AxisResult) -> Iterator[Table]:
    """Yield the tables of every loaded ball contact and of every roller."""
    names = [s.of.name for s in result.sets]
    rows: list[Row] = [
        {
            Quantity("set", "set", "", "s"): names[row["set"] - 1],
            Quantity("ball", "ball"): row["index"],
            Quantity("side", "flank", "", "s"): side,
            Quantity("load", "load", "N", ".1f"): row["load_N"][side],
            Quantity("angle", "contact angle", "deg", ".2f"): row["contact_angle_deg"][side],
            Quantity("pressure", "peak pressure", "MPa", ".0f"): row["pressure_MPa"][side],
        }
        for row in ball_rows_of_axis(result)
        for side in SIDES
        if row["load_N"][side]
    ]
    if rows:
        yield Table.of("contacts", "Every loaded contact of balls", rows, "Peak pressure: Hertz, each contact's own radii.")
    found: list[Row] = [
        {
            Quantity("set", "set", "", "s"): names[row["set"] - 1],
            Quantity("roller", "roller"): row["index"],
            Quantity("load", "load", "N", ".1f"): row["load_N"],
            Quantity("line", "largest line load", "N/mm", ".1f"): row["largest_line_load_N_mm"],
            **{Quantity(race, f"{race} race", "MPa", ".0f"): row["pressure_MPa"][race] for race in RACES},
        }
        for row in roller_rows(result)
    ]
    if found:
        yield Table.of("rollers", "Every roller", found, "Largest pressure along the roller at either race.")
