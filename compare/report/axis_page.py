"""``rollbench report SCENE`` for a shaft that carries several ball nuts or bearings: the page on one load case."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from rollbench.compare.errors import SceneNotCoveredError
from rollbench.compare.models.answers import ShaftResults
from rollbench.compare.models.load_cases import ShaftSolution
from rollbench.compare.report import parts as report_parts
from rollbench.compare.results.rows import bearing_and_nut_rows, expected_error_sentence, solution_rows
from rollbench.compare.results.scene_json import ball_rows_of_shaft_json, roller_rows_json, solved_case_json
from rollbench.compare.results.view import collect_view_data
from rollbench.lowfi.rating.contacts import RACES
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.parts import FREEDOMS, SIDES
from rollbench.reports.content import Row, Section, Table, TableColumn, text_column
from rollbench.reports.scene_page import ScenePage


def result_page_of_shaft(scene_name: str, solved_shaft: ShaftSolution, stores: Sequence[Path]) -> ScenePage:
    """Return the page with the results of a shaft that carries several ball nuts or bearing rows.

    Parameters
    ----------
    scene_name
        Path of the scene file, or name of a shipped scene.
    solved_shaft
        Solution of the shaft under one load case.
    stores
        Folders with stored runs of the 3D reference.

    Returns
    -------
    ScenePage
        Page with the results.

    Raises
    ------
    SceneNotCoveredError
        If the scene has no solution.
    """
    scene, result = solved_shaft.scene, solved_shaft.result
    if solved_shaft.derived_results is None:
        advice = f"solve the scene to see the reason: rollbench solve {shlex.quote(scene_name)}"
        raise SceneNotCoveredError(scene_name, "scene", f"no usable solution: {result.status}", advice)
    text, data = report_parts.scene_file_text(scene_name), solved_case_json(solved_shaft)
    parts = [
        Section("sets", "Forces and stiffness of nuts and bearings", _force_and_stiffness_tables(solved_shaft)),
        Section("loads", "Contact loads and contact pressures", [*_contact_load_tables(result)]),
    ]
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure and life by rollbench, model {result.model}",
        highest_pressure_sentence(result, solved_shaft.derived_results),
        (),
        None,
        (*parts, report_parts.warnings_and_assumptions_section(result)),
        report_parts.page_origin_facts(scene_name, scene, text, result.model),
        text,
        data,
        report_parts.source_code_hash_by_name(),
        view=collect_view_data(scene.title, [solved_shaft], data, (), stores),
        table=report_parts.results_table(
            solution_rows(solved_shaft),
            f"Results by the model {result.model}",
            expected_error_sentence(solved_shaft.expected_errors),
        ),
    )


def highest_pressure_sentence(result: AxisResult, answers: ShaftResults) -> str:
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
    if not answers.set_indices_by_pressure:
        return "No contact carries load."
    k = answers.set_indices_by_pressure[0]
    worst, safety = answers.set_results[k].load_results.worst_contact, answers.set_results[k].load_results.safety
    assert worst is not None
    assert safety is not None
    return (
        f"The contact with the highest pressure, in {result.sets[k].of.name}, carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {safety.factor:.2g}; errors are not estimated for a shaft with "
        "several nuts or bearings."
    )


def _force_and_stiffness_tables(solved_shaft: ShaftSolution) -> list[Table]:
    """Return the table of force and stiffness of each nut and bearing and, if computed, the stiffness of the whole shaft.

    ``solved_shaft``: the solved shaft.
    """
    result = solved_shaft.result
    rows: list[Row] = [
        {TableColumn(head, head, "", "s" if head == "set" else "g4"): text for head, text in row.items()}
        for row in bearing_and_nut_rows(solved_shaft)
    ]
    tables = [Table.from_rows("sets", "Force on the shaft and stiffness of each nut or bearing", rows)]
    if result.stiffness is not None:
        cells: list[Row] = []
        for freedom, line in zip(FREEDOMS, result.stiffness, strict=True):
            cell: Row = {text_column("freedom", "component of force or moment"): freedom}
            for f, x in zip(FREEDOMS, line, strict=True):
                cell[TableColumn(f, f"per unit of {f}")] = None if np.isnan(x) else float(x)
            cells.append(cell)
        note = (
            f"{result.stiffness_at}; a row for each component of force [N] and moment [N m], a column for each "
            "displacement [m] and rotation [rad]; a dash: a fixed degree of freedom."
        )
        tables.append(Table.from_rows("tangent", "Tangent stiffness of the whole shaft, 6 x 6", cells, note))
    return tables


def _contact_load_tables(result: AxisResult) -> Iterator[Table]:
    """Yield a table of all loaded ball contacts and a table of all rollers; each only if there are any.

    ``result``: solution of a shaft that carries several nuts or bearings.
    """
    names = [s.of.name for s in result.sets]
    rows: list[Row] = [
        {
            text_column("set", "nut or bearing"): names[row["set"] - 1],
            TableColumn("ball", "number of the ball"): row["index"],
            text_column("side", "flank of the groove"): side,
            TableColumn("load", "contact load", "N", ".1f"): row["load_N"][side],
            TableColumn("angle", "contact angle", "deg", ".2f"): row["contact_angle_deg"][side],
            TableColumn("pressure", "peak pressure", "MPa", ".0f"): row["pressure_MPa"][side],
        }
        for row in ball_rows_of_shaft_json(result)
        for side in SIDES
        if row["load_N"][side]
    ]
    if rows:
        note = "Peak pressure by Hertz theory with the radii of each contact."
        title = "Contact load, contact angle and peak pressure of every loaded ball contact"
        yield Table.from_rows("contacts", title, rows, note)
    found: list[Row] = [
        {
            text_column("set", "bearing"): names[row["set"] - 1],
            TableColumn("roller", "number of the roller"): row["index"],
            TableColumn("load", "load of the roller", "N", ".1f"): row["load_N"],
            TableColumn("line", "largest line load", "N/mm", ".1f"): row["largest_line_load_N_mm"],
            **{
                TableColumn(race, f"largest pressure, {race} raceway", "MPa", ".0f"): row["pressure_MPa"][race]
                for race in RACES
            },
        }
        for row in roller_rows_json(result)
    ]
    if found:
        note = "Pressures are the largest along the roller, on either raceway."
        yield Table.from_rows("rollers", "Load, line load and pressure of every roller", found, note)
