"""``rollbench report SCENE`` for a shaft that carries several ball nuts or bearings: the page on one load case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from rollbench.compare.errors import Refusal
from rollbench.compare.models.answers import AxisAnswers
from rollbench.compare.models.load_cases import SolvedAxis
from rollbench.compare.report.parts import (
    page_provenance,
    results_table,
    scene_text,
    source_code_hash,
    warnings_and_assumptions_section,
)
from rollbench.compare.results.rows import bearing_and_nut_rows, expected_error_sentence, solution_rows
from rollbench.compare.results.scene_json import ball_rows_of_axis, roller_rows, solved_case_json
from rollbench.compare.results.view import collect_view_data
from rollbench.lowfi.rating.contacts import RACES
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.parts import FREEDOMS, SIDES
from rollbench.reports.content import Quantity, Row, Section, Table
from rollbench.reports.scene_page import ScenePage


def page_of_axis(name: str, one: SolvedAxis, stores: Sequence[Path]) -> ScenePage:
    """Return the page with the results of a shaft that carries several ball nuts or bearing rows.

    Parameters
    ----------
    name
        Path of the scene file, or name of a shipped scene.
    one
        Solution of the shaft under one load case.
    stores
        Folders with stored runs of the 3D reference.

    Returns
    -------
    ScenePage
        Page with the results.

    Raises
    ------
    Refusal
        If the scene has no solution.
    """
    scene, result = one.scene, one.result
    if one.answers is None:
        raise Refusal(name, "scene", result.status, "see the status of the solution: rollbench solve")
    text, data = scene_text(name), solved_case_json(one)
    parts = [
        Section("sets", "Forces and stiffness of nuts and bearings", _force_and_stiffness_tables(one)),
        Section("loads", "Contact loads and pressures", [*_contact_load_tables(result)]),
    ]
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure and life by rollbench, model {result.model}",
        highest_pressure_sentence(result, one.answers),
        (),
        None,
        (*parts, warnings_and_assumptions_section(result)),
        page_provenance(name, scene, text, result.model),
        text,
        data,
        source_code_hash(),
        view=collect_view_data(scene.title, [one], data, (), stores),
        table=results_table(solution_rows(one), f"Results by the model {result.model}", expected_error_sentence(None)),
    )


def highest_pressure_sentence(result: AxisResult, answers: AxisAnswers) -> str:
    """Return the main result of a shaft as one sentence: the contact with the highest pressure relative to its limit.

    Parameters
    ----------
    result
        Solution of a shaft that carries several ball nuts or bearing rows.
    answers
        Results derived from the contact loads of this solution.

    Returns
    -------
    str
        Sentence with load [N], pressure [MPa] and static safety of this contact, or that no contact carries load.
    """
    if not answers.sets_by_pressure:
        return "No contact carries load."
    k = answers.sets_by_pressure[0]
    worst, safety = answers.sets[k].loads.worst, answers.sets[k].loads.safety
    assert worst is not None
    assert safety is not None
    return (
        f"The contact with the highest pressure, in {result.sets[k].of.name}, carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {safety.factor:.2g}; errors are not estimated for several sets."
    )


def _force_and_stiffness_tables(one: SolvedAxis) -> list[Table]:
    """Return the table of force and stiffness of each nut and bearing and, if computed, the stiffness of the whole shaft.

    ``one``: the solved shaft.
    """
    result = one.result
    rows: list[Row] = [
        {Quantity(head, head, "", "s" if head == "set" else "g4"): text for head, text in row.items()}
        for row in bearing_and_nut_rows(one)
    ]
    tables = [Table.of("sets", "Force on the shaft and stiffness of each nut or bearing", rows)]
    if result.stiffness is not None:
        cells: list[Row] = []
        for freedom, line in zip(FREEDOMS, result.stiffness, strict=True):
            cell: Row = {Quantity("freedom", "force or moment", "", "s"): freedom}
            cell |= {Quantity(f, f): None if np.isnan(x) else float(x) for f, x in zip(FREEDOMS, line, strict=True)}
            cells.append(cell)
        note = f"{result.stiffness_at}; a dash: a fixed freedom; rows and columns in N, N m, m and rad."
        tables.append(Table.of("tangent", "Tangent stiffness of the whole shaft, 6 x 6", cells, note))
    return tables


def _contact_load_tables(result: AxisResult) -> Iterator[Table]:
    """Yield a table of all loaded ball contacts and a table of all rollers; each only if there are any.

    ``result``: solution of a shaft that carries several nuts or bearings.
    """
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
        note = "Peak pressure by Hertz theory with the radii of each contact."
        yield Table.of("contacts", "Load, contact angle and pressure of every loaded ball contact", rows, note)
    found: list[Row] = [
        {
            Quantity("set", "set", "", "s"): names[row["set"] - 1],
            Quantity("roller", "roller"): row["index"],
            Quantity("load", "load", "N", ".1f"): row["load_N"],
            Quantity("line", "largest line load", "N/mm", ".1f"): row["largest_line_load_N_mm"],
            **{Quantity(race, f"pressure, {race} race", "MPa", ".0f"): row["pressure_MPa"][race] for race in RACES},
        }
        for row in roller_rows(result)
    ]
    if found:
        note = "Pressures are the largest along the roller, on either raceway."
        yield Table.of("rollers", "Load, line load and pressure of every roller", found, note)
