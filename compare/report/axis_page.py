"""``rollbench report SCENE`` for a shaft that carries several ball nuts or bearings: the page on one load case."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from rollbench.compare.errors import InputError, SceneNotCoveredError
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.report import parts as report_parts
from rollbench.compare.results.rows import bearing_and_nut_rows, expected_error_sentence
from rollbench.compare.results.solved import Result
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.friction.solve import solve_friction_of_scene
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.lowfi.rating.contacts import RACES, WorstContact
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Row, Section, Table, Text
from rollbench.reports.scene_html import ScenePage


def result_page_of_shaft(scene_name: str, found: Result, stores: Sequence[Path]) -> ScenePage:
    """Return the page with the results of a shaft that carries several ball nuts or bearing rows.

    Parameters
    ----------
    scene_name
        Path of the scene file, or name of a shipped scene.
    found
        Results of the shaft under one load case.
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
    scene, result = found.described, found.solution
    assert isinstance(scene, Assembly)
    if not found.converged:
        advice = f"solve the scene to see the reason: rollbench solve {shlex.quote(scene_name)}"
        raise SceneNotCoveredError(scene_name, "scene", f"no usable solution: {result.status}", advice)
    text, _ = catalogue.scene_text_and_file_name(scene_name)
    loads = found.figure()
    parts = [
        Section("sets", "Forces and stiffness of nuts and bearings", _force_and_stiffness_tables(found)),
        *_friction_sections(scene),
        Section(
            "loads", "Contact loads and contact pressures", [*filter(None, [loads]), *_contact_load_tables(found.sets)]
        ),
    ]
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure and life by rollbench, model {result.model}",
        highest_pressure_sentence(found.worst, found.expected_error),
        (),
        None,
        (*parts, report_parts.warnings_and_assumptions_section(result)),
        report_parts.page_origin_facts(scene_name, scene, text, result.model),
        text,
        found.to_json(),
        report_parts.source_code_hash_by_name(),
        view=found.scene_view(stores),
        table=report_parts.results_table(
            found.rows(), f"Results by the model {result.model}", expected_error_sentence(found.expected_error)
        ),
    )


def highest_pressure_sentence(worst: WorstContact | None, expected_error: ExpectedError | None) -> str:
    """Return the main result of a shaft as one sentence: the contact with the highest pressure relative to its limit.

    Parameters
    ----------
    worst
        This contact; None if no contact carries load.
    expected_error
        Expected error of the contact loads; None: not known for this shaft.

    Returns
    -------
    str
        Sentence with load [N], pressure [MPa], static safety and expected error of this contact, or that no contact
        carries load.
    """
    if worst is None:
        return "No contact carries load."
    error = "the error of these loads is not known for this shaft; rollbench compare measures it"
    if expected_error is not None and expected_error.loads is not None:
        error = f"by comparison of similar scenes, expect an error of up to {expected_error.loads:.1f} % of the mean load"
    return (
        f"The contact with the highest pressure, in {worst.set}, carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {worst.safety:.2g}; {error}."
    )


def _force_and_stiffness_tables(found: Result) -> list[Table]:
    """Return the table of force and stiffness of each nut and bearing and, if computed, the stiffness of the whole shaft.

    ``found``: results of the shaft.
    """
    stiffness, place = found.stiffness, found.place_of_stiffness.partition(",")[0].removeprefix("at ")
    rows = report_parts.rows_under_own_headings(bearing_and_nut_rows(found.sets), "set")
    tables = [Table.from_rows("sets", "Force on the shaft and stiffness of each nut or bearing", rows)]
    if stiffness is not None:
        free = [k for k, line in enumerate(stiffness) if not np.isnan(line).all()]
        note = (
            f"{place[:1].upper()}{place[1:]}; a row for each component of force [N] and moment [N m], a column for each "
            "displacement [m] and rotation [rad]. The other degrees of freedom are held."
        )
        tables.append(
            Table.from_rows(
                "tangent", "Tangent stiffness of the whole shaft", report_parts.stiffness_rows(stiffness, free), note
            )
        )
    return tables


def _friction_sections(scene: Assembly) -> Iterator[Section]:
    """Yield the section on the friction of a shaft; none if the scene states no coefficient of friction."""
    if scene.friction is None:
        return
    title = "Friction torque and losses"
    try:
        found = solve_friction_of_scene(scene, FrictionChoices(), scene.name)
    except InputError as error:  # a nut that turns
        yield Section("friction", title, [Text((f"Friction was not computed: {error}.",))])
        return
    figure = found.figure()
    table = report_parts.results_table(found.rows(), "Torques, efficiency and power lost", name="torques")
    yield Section("friction", title, [table, *filter(None, [figure])])


def _contact_load_tables(sets: Mapping[str, SetResult]) -> Iterator[Table]:
    """Yield a table of all loaded ball contacts and a table of all rollers; each only if there are any.

    ``sets``: results of each nut or bearing by name.
    """
    rows: list[Row] = [
        {
            "nut_or_bearing": name,
            "ball": ball.index,
            "flank": side,
            "contact_load": float(ball.load[k]),
            "contact_angle": float(np.degrees(ball.angle[k])),
            "peak_pressure": 1e-6 * float(ball.pressure[k]),
        }
        for name, s in sets.items()
        for ball in s.ball_rows()
        for k, side in enumerate(SIDES)
        if ball.load[k]
    ]
    if rows:
        note = "Peak pressure by Hertz theory with the radii of each contact."
        title = "Contact load, contact angle and peak pressure of every loaded ball contact"
        yield Table.from_rows("contacts", title, rows, note)
    found: list[Row] = [
        {
            "nut_or_bearing": name,
            "roller": roller.index,
            "roller_load": float(roller.load),
            "largest_line_load": 1e-3 * float(roller.line_load),
            **{("raceway_pressure", race): 1e-6 * float(roller.pressure[race]) for race in RACES},
        }
        for name, s in sets.items()
        for roller in s.roller_rows()
    ]
    if found:
        note = "Pressures are the largest along the roller, on either raceway."
        yield Table.from_rows("rollers", "Load, line load and pressure of every roller", found, note)
