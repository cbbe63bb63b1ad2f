"""``rollbench report SCENE``: a page with the results of one screw or bearing, for the user's customers.

It shows contact loads, stiffness, friction and the errors to expect. The section on friction shows the torque over a turn,
the losses, and the effect of the friction coefficient and of the play.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.gate.user import references_from_file
from rollbench.compare.measure import load_error
from rollbench.compare.models.comparison import solution_from_result
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import FILE, ExpectedError
from rollbench.compare.models.registry import DEFAULT, default_model_name, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import QUANTITIES, ErrorWithUncertainty, error_with_validation_uncertainty
from rollbench.compare.quantities import count_with_noun
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.reference.store import path_of_run, shipped_store
from rollbench.compare.report import parts
from rollbench.compare.report.axis_page import result_page_of_shaft
from rollbench.compare.results.friction_run import TransientRun
from rollbench.compare.results.rows import expected_error_sentence
from rollbench.compare.results.solved import Result
from rollbench.compare.results.solving import combine_load_cases, solve_with_results
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.scenes.scene_file import kind_of_scene
from rollbench.compare.sections.curves import contact_load_curve, contact_load_panel
from rollbench.compare.sections.fit import validated_range_figure, validated_range_table
from rollbench.compare.sections.sketches import sketch_scene
from rollbench.compare.studies.friction.run import simulate_friction_over_time
from rollbench.compare.studies.friction.whole import (
    MEASURED,
    StaticallySolvedPart,
    friction_of_solved_loads,
    friction_status,
)
from rollbench.compare.text.solved import load_case_rows
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.rating.contacts import WorstContact
from rollbench.lowfi.statics.contacts import hertz_of_every_contact
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene, Time
from rollbench.reports.content import Figure, LoadedScrew, Panel, Row, Section, Series, Table, Text
from rollbench.reports.manifest import sha256
from rollbench.reports.scene_html import ScenePage

#: Title of the sketch of the scene.
SKETCH = "Side view of screw, nut and balls, to scale near the nut; hatched: surfaces at which the nut is fixed"


@contextmanager
def raise_folder_errors_as_input_errors(out: Path) -> Iterator[None]:
    """Raise InputError in place of the OSError or ValueError of a ``with`` block that writes a report to a folder.

    ``out``: the folder. InputError is also raised, before the block, if it contains files that do not belong to a report.
    """
    from rollbench.reports.pages import check_report_folder

    try:
        check_report_folder(out)
        yield
    except (ValueError, OSError) as error:
        allowed = "a folder that is new, is empty, or contains an earlier report"
        raise ArgumentError("out", str(error), allowed, "choose another folder", str(out)) from None


def solve_and_make_page(
    scene_name: str, stores: Sequence[Path], reference_file: Path | None = None
) -> tuple[ScenePage, Result]:
    """Solve a scene by the default model and make its result page, on the load case with the highest pressure.

    Parameters
    ----------
    scene_name
        Name or file of the scene.
    stores
        Folders with stored runs of the 3D reference.
    reference_file
        File with contact loads that replaces the 3D reference.

    Returns
    -------
    ScenePage, Result
        Page with the results, and the results.

    Raises
    ------
    InputError
        For a scene that cannot be shown, or a file of loads for a shaft with several nuts or bearings. If the scene has no
        solution, the subclass SceneNotCoveredError.
    """
    described = catalogue.scene_of_any_kind(scene_name)
    sets = isinstance(described.parts if isinstance(described, DutyCycle) else described, Assembly)
    if sets and reference_file is not None:
        allowed = "only with a scene of a single nut or bearing"
        raise ArgumentError("reference", str(reference_file), allowed, "leave it out", scene_name)
    if isinstance(described, DutyCycle):
        return _page_of_highest_pressure_case(scene_name, described, stores, reference_file)
    if isinstance(described, Assembly):
        found = solve_with_results(described, default_model_name(described), ModelOptions())
        return result_page_of_shaft(scene_name, found, stores), found
    scene = scene_file.single_nut_scene_or_raise(described, scene_name)
    return _page_of_load_case(scene_name, scene, stores, reference_file)


def _page_of_highest_pressure_case(
    scene_name: str, cycle: DutyCycle, stores: Sequence[Path], reference_file: Path | None
) -> tuple[ScenePage, Result]:
    """Return the page on a duty cycle's load case with the highest pressure, and all results; a table of cases comes first.

    ``scene_name``: name or file of the scene. ``cycle``: its load cases. ``stores``: folders with stored runs of the 3D
    reference. ``reference_file``: file with contact loads that replaces the 3D reference. Raises SceneNotCoveredError if no
    load case converges and loads a contact.
    """
    scenes = [case.scene for case in cycle.cases]
    solved = [solve_with_results(scene, default_model_name(scene), ModelOptions()) for scene in scenes]
    found = combine_load_cases(cycle, solved)
    whole = found.together
    if whole.pressure is None:
        value = "no load case that has a solution with loaded contacts"
        raise SceneNotCoveredError(scene_name, "cases", value, "see the status of each load case: rollbench solve")
    worst = whole.pressure.case
    one = found.cases[worst]
    if isinstance(one.described, Assembly):
        page = result_page_of_shaft(scene_name, one, stores)
    else:
        page, _ = _page_of_load_case(scene_name, one.described, stores, reference_file, worst)
    answers = found.table()
    lives = (
        f"{row.quantity} {row.value} {row.unit}" for row in answers if row.quantity.startswith("life L10") and row.unit
    )
    life_said = ", ".join(lives) or "not known"
    note = "Life: if only this load case acted. The sections below show the load case with the highest pressure."
    rows = parts.rows_under_own_headings(load_case_rows(found), "case")
    table = Table.from_rows("cases", "Contact load, pressure, safety and life of each load case", rows, note)
    lost = "".join(f" Case {one} was not solved: {status}." for one, status in whole.unsolved.items())
    cases = count_with_noun(len(solved), "load case")
    page = replace(
        page,
        title=cycle.title,
        subtitle=f"{cycle.name}, {cases}: {page.subtitle.partition(': ')[2]}; shown below: case {worst}",
        verdict=f"Of {cases}, {worst} has the highest pressure. {page.verdict} Lives: {life_said}.{lost}",
        table=parts.results_table(answers, "Results of all load cases together"),
        parts=(Section("cases", "Load cases", (table, *filter(None, [page.table]))), *page.parts),
        results=found.to_json(),
        view=found.scene_view(stores),
    )
    return page, found


def _page_of_load_case(
    scene_name: str,
    scene: Scene,
    stores: Sequence[Path],
    reference_file: Path | None = None,
    load_case_name: str | None = None,
) -> tuple[ScenePage, Result]:
    """Return the page on one load case of a scene that has a single nut or bearing row, and its results.

    ``scene_name``: name or file of the scene. ``stores``: folders with stored runs of the 3D reference. ``reference_file``:
    file with contact loads that replaces the 3D reference. ``load_case_name``: name of the load case, to which the rows of
    the file are restricted. Raises SceneNotCoveredError if the scene has no solution.
    """
    study, warnings = SceneResultCache(stores, scenes={scene.name: scene}), list[str]()
    given = None
    if reference_file is not None:
        given = references_from_file(reference_file, scene, warnings.append, case=load_case_name)[0].reference
    options = ModelOptions()
    one = solve_with_results(scene, DEFAULT, options, scene.nut.position)
    result, worth, tangent = one.solution, one.expected_error, one.tangent
    assert isinstance(result, StaticResult)
    if worth is None or tangent is None:
        advice = f"solve the scene to see the reason: rollbench solve {shlex.quote(scene_name)}"
        raise SceneNotCoveredError(scene_name, "scene", f"no usable solution: {result.status}", advice)
    stored = study.stored_reference(scene.name)
    solution = solution_from_result(result)
    errors = (error_with_validation_uncertainty(study, scene.name, DEFAULT, q, solution) for q in QUANTITIES)
    judged = [error for error in errors if error is not None]
    clause = "" if given is None else error_against_file_clause(given, result)
    text, _ = catalogue.scene_text_and_file_name(scene_name)
    title = f"Results by the model {DEFAULT}, each with its expected error"
    sections = (
        Section("scene", "Geometry of the screw or bearing", (sketch_scene(scene, "sketch", SKETCH),)),
        _loads_section(scene, result, [reference for reference in (given, stored) if reference is not None]),
        _stiffness_section(one, tangent),
        *filter(None, [friction_section(scene, result, options)]),
        _error_section(scene, worth, judged, stored, given, clause),
        parts.warnings_and_assumptions_section(result, warnings),
    )
    page = ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure, friction and life by rollbench, model {DEFAULT}",
        pressure_and_error_sentence(one.worst, worth, judged, stored, f"{given.stated}, {clause}" if given else ""),
        (),
        _picture_of_scene(scene, result),
        sections,
        _scene_origin_facts(scene_name, scene, text, stored, reference_file),
        text,
        one.to_json(),
        _hashes_of_used_files(scene, stored, stores),
        warnings,
        one.scene_view(stores, given),
        table=parts.results_table(one.rows(), title, expected_error_sentence(worth)),
    )
    return page, one


def error_against_file_clause(file_reference: Reference, result: StaticResult) -> str:
    """Return the clause that states the largest error of a computed load against the user's reference file.

    ``file_reference``: contact loads of the file. ``result``: the solution.
    """
    e = load_error(result.load, file_reference.load, file_reference.contacts)
    return f"loads differ by up to {e.max_percent:.2f} % of the mean load (ball {e.ball} {e.side})"


def pressure_and_error_sentence(
    worst: WorstContact | None,
    expected_error: ExpectedError,
    measured_errors: Sequence[ErrorWithUncertainty],
    reference: Reference | None,
    file_text: str,
) -> str:
    """Return the main result of a scene as one sentence: highest pressure, static safety, and error of the loads.

    Parameters
    ----------
    worst
        Contact with the highest pressure; None: no contact carries load.
    expected_error
        Expected error of the loads, estimated from other scenes that were compared with the 3D reference.
    measured_errors
        Errors measured against the stored 3D reference, that of the contact loads first; empty without a reference.
    reference
        Stored 3D reference; None: not stored.
    file_text
        Clause on the errors against the user's reference file; empty: no file.
    """
    if worst is None:
        return "No contact carries load."
    text = (
        f"The contact with the highest pressure (ball {worst.element} {worst.side}) carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {worst.safety:.2g}"
    )
    if file_text:
        return f"{text}; {file_text}."
    if measured_errors and reference is not None:
        v = measured_errors[0]
        parts = [("numerical uncertainty (mesh)", v.uncertainty.discretisation)]
        parts += [("input uncertainty (tolerances)", v.uncertainty.inputs or 0.0)]
        bars = [f"{name} {f'{part:.2f} %' if np.isfinite(part) else 'not known'}" for name, part in parts]
        bar = "; ".join(filter(None, [*bars, reference.unsettled]))
        return f"{text}; loads differ from the 3D reference by up to {abs(v.error):.2f} % of the mean load ({bar})."
    if expected_error.loads is None:
        return f"{text}; the error of these loads is unknown because no similar scene was compared with the 3D reference."
    return (
        f"{text}; by comparison of similar scenes, expect an error of up to {expected_error.loads:.1f} % of the mean load."
    )


def _loads_section(scene: Scene, result: StaticResult, references: Sequence[Reference]) -> Section:
    """Return the section with loads and pressures of all contacts, next to the loads of the references.

    ``result``: solution of the scene. ``references``: the user's reference file and the stored 3D reference, as far as they
    exist.
    """
    panels = []
    geometry = draw_geometry_with_errors(scene, ball_layout(scene), result.member)
    pressure = 1e-6 * hertz_of_every_contact(scene, geometry).pressure(result.load)
    for s, side in enumerate(SIDES[:2]):  # a ball's contact with the nut carries nearly the load of that opposite to it
        if not (result.load[:, s] > 0.0).any():
            continue
        series = [contact_load_curve(r.label, r, s, "markers", uncertainty=r.uncertainty) for r in references]
        series.insert(0, contact_load_curve(DEFAULT, result, s, emphasis=True))
        panels.append(contact_load_panel(f"screw flank {side}", *series, axis_from_zero=True))
    rows: list[Row] = []
    for i, s in zip(*np.nonzero(result.load > 0.0), strict=True):
        row: Row = {"ball": int(i) + 1, "flank": SIDES[int(s)], ("load_of", f"{DEFAULT} model"): float(result.load[i, s])}
        for reference in references:
            row["load_of", reference.label] = float(reference.load[i, s])
        row["contact_angle"] = float(np.degrees(result.contact_angle[i, s]))
        row["peak_pressure"] = float(pressure[i, s])
        rows.append(row)
    items: list[Figure | Table] = [Figure("loads", "Contact load of every ball", tuple(panels))] if panels else []
    note = "Peak pressure by Hertz theory with the radii of each contact."
    title = "Contact load, contact angle and peak pressure of every loaded contact"
    items.append(Table.from_rows("contacts", title, rows, note))
    return Section("loads", "Contact loads and pressures", items)


def _stiffness_section(found: Result, tangent: TangentStiffness) -> Section:
    """Return the section on stiffness: axial rigidities by ISO 3408-4 and by the model, and the 6 x 6 tangent matrix.

    ``found``: results of the scene. ``tangent``: stiffness of the screw at the nut's centre.
    """
    at_load, nut, three = found.load_point, found.nut, None if found.only is None else found.only.rigidities
    assert nut is not None
    assert at_load is not None
    names = (
        "of the contacts alone (R_b/t), by formula at the nominal contact angle",
        "of contacts and bodies (R_nu), by formula at the nominal contact angle",
        f"secant rigidity of the {nut.of} by the model (R_nu,ar)",
        f"tangent rigidity of the {nut.of} by the model at this load",
        f"secant rigidity of the load's point at {at_load.at}, to ground",
        f"tangent rigidity of the load's point at {at_load.at}, to ground",
    )
    values = (None,) * 3 if three is None else (three.contacts_only, three.with_bodies, three.with_unequal_loads)
    rows: list[Row] = [
        {"rigidity_kind": name, "axial_rigidity": None if value is None else 1e-6 * value}
        for name, value in zip(names, (*values, nut.tangent, at_load.secant, at_load.tangent), strict=True)
    ]
    first = Table.from_rows("rigidity", "Axial rigidity by the formulas of ISO 3408-4 and by the model", rows)
    title = "Axial rigidity and stiffness"
    if tangent.status != "converged":
        return Section("stiffness", title, (first, Text((f"Tangent stiffness: {tangent.status}.",))))
    note = (
        "For displacements [m] and rotations [rad] of the screw at the nut's centre; the rows are forces [N] and moments "
        "[N m]. The supports of the screw are left out, and every other motion is held."
    )
    second = Table.from_rows(
        "tangent", "Tangent stiffness of the screw in the nut, 6 x 6", parts.stiffness_rows(tangent.matrix), note
    )
    return Section("stiffness", title, (first, second))


def _error_section(
    scene: Scene,
    expected_error: ExpectedError,
    measured_errors: Sequence[ErrorWithUncertainty],
    reference: Reference | None,
    file_reference: Reference | None,
    file_clause: str,
) -> Section:
    """Return the section on the errors of the results.

    It shows the errors measured against references with their validation uncertainty u_val, the error to expect, and
    whether the scene lies in the range of the scenes that were compared with the 3D reference.

    ``expected_error``: expected error, estimated from other scenes. ``measured_errors``: errors measured against the stored
    3D reference; empty without one. ``reference``: this reference. ``file_reference``: the user's
    reference file; None: no file. ``file_clause``: clause on the errors against it.
    """
    items: list[Text | Table | Figure] = []
    if file_reference is not None:
        origin, bar = file_reference.stated, largest_uncertainty_percent(file_reference)
        text = f"{origin[:1].upper()}{origin[1:]}: {file_clause}, uncertain by up to {bar:.2f} %."
        items.append(Text((text,)))
    if measured_errors and reference is not None:
        levels = ", ".join(str(run.level) for run in reference.runs)
        rows: list[Row] = [
            {
                "quantity": v.quantity,
                "error_against_reference": v.error,
                "u_mesh": v.uncertainty.discretisation,
                "u_choices": v.uncertainty.choices,
                "u_inputs": v.uncertainty.inputs,
                "u_val": v.uncertainty.total,
            }
            for v in measured_errors
        ]
        note = (
            f"Errors against the 3D reference on mesh levels {levels}. Contact loads: the worst contact, in per cent of "
            "the mean load. u_val is the root of the sum of squares of the three uncertainties (ASME V&V 20). The effect "
            "of modelling choices of the 3D reference was computed on a few scenes and is transferred to the others."
        )
        title = "Error of each result against the 3D reference, and uncertainty of the error"
        items.append(Table.from_rows("measured", title, rows, note))
    else:
        text = "The error was not measured: no run of the 3D reference is stored for this scene (rollbench mesh-study)."
        items.append(Text((text,)))
    expected = expected_error_sentence(expected_error)
    items.append(Text((expected[:1].upper() + expected[1:] + ".",)))
    try:
        items += [validated_range_table(scene), validated_range_figure(scene)]
    except ValueError as error:
        items.append(Text((f"The scene cannot be compared with the range of validated scenes: {error}.",)))
    return Section("error", "Errors of the results on this page", items)


def _picture_of_scene(scene: Scene, result: StaticResult) -> LoadedScrew:
    """Return the 3D picture of the loaded screw, with balls coloured by load and the contact forces as arrows."""
    loaded = result.load > 0.0
    arrows = result.contact_point[loaded], (result.force_direction * result.load[..., None])[loaded]
    caption = "Colour of a ball: its largest contact load. Arrows: contact forces on the balls."
    return LoadedScrew("picture", "Loads of the balls and contact forces on them", scene, result.load, *arrows, caption)


def _hashes_of_used_files(scene: Scene, reference: Reference | None, stores: Sequence[Path]) -> dict[str, str]:
    """Return the SHA-256 of the program's source code, of the stored model errors and of the 3D runs, by file name.

    ``reference``: 3D reference whose runs were used; None: none. ``stores``: folders in which its runs are looked up.
    """
    paths = [shipped_store() / FILE]
    for run in () if reference is None else reference.runs:
        paths += [p for store in stores if (p := path_of_run(store, scene, run)).exists()][:1]
    return parts.source_code_hash_by_name() | {path.name: sha256(path.read_bytes()) for path in paths if path.exists()}


def _scene_origin_facts(
    scene_name: str, scene: Scene, toml_text: str, reference: Reference | None, reference_file: Path | None
) -> dict[str, str]:
    """Return what the page states about its origin, by label: scene file, versions, date, and 3D runs of the reference.

    ``scene_name``: name or file of the scene. ``toml_text``: its TOML text. ``reference``: 3D reference; None: not stored.
    ``reference_file``: the user's file of contact loads; None: no file.
    """
    out = parts.page_origin_facts(scene_name, scene, toml_text, DEFAULT)
    if reference is not None:
        runs = (f"level {r.level} of {r.date}, rollbench {r.versions.get('rollbench', '?')}" for r in reference.runs)
        out["3D reference"] = "; ".join(runs)
    if reference_file is not None:
        out["reference"] = f"{reference_file.name}, SHA-256 {sha256(reference_file.read_bytes())}"
    return out


#: Number of time steps for the friction over one turn, if the scene states no time span.
STEPS = 24

#: Changes of all ball radii from those of the scene [m], at which the figure shows the friction torque.
PLAY = (-10e-6, -5e-6, -2e-6, 0.0, 2e-6)


def friction_section(scene: Scene, result: StaticResult, options: ModelOptions) -> Section | None:
    """Return the section on friction: torque, losses, and effect of the friction coefficient and of the ball size.

    ``result``: static solution without friction. ``options``: options of the model. Returns None if the scene has no
    friction coefficient.
    """
    if scene.friction is None:
        return None
    motion, title = scene.motion or ONE_TURN, "Friction torque and losses"
    bare = run_model(replace(scene, loads=()), DEFAULT, options) if scene.loads else result
    solved = StaticallySolvedPart(scene, DEFAULT, options, scene.friction, motion, bare)
    try:
        (state,) = solved.states([solved.case(result, scene.friction)])
    except ValueError as error:  # balls that overlap by their random sizes
        return Section("friction", title, (Text((f"Friction was not computed: {error}.",)),))
    if not state.all_balanced:
        return Section("friction", title, (Text((f"Friction was not computed: {friction_status(state)}.",)),))
    head = {"scene": scene.name, "title": scene.title, "kind": kind_of_scene(scene)}
    found = friction_of_solved_loads(solved, result, [scene.friction], [state], **head)
    panels = [_torque_over_coefficient_panel(solved, result), _torque_over_ball_size_panel(solved)]
    notes = [" ".join(filter(None, (f"{row.quantity}:", row.value, row.unit, row.note))) for row in found.rows()]
    notes += [f"third flank: {text}." for text in found.warnings if text.kind == "third flank"]
    angle = 2.0 * np.pi / (scene.ball_count if scene.track.lead == 0.0 else 1.0)
    time = scene.time or Time(duration=abs(angle / motion.speed), steps=STEPS, goal=1.0, output="torque")
    try:
        run = simulate_friction_over_time(replace(scene, time=time), scene.friction, motion, DEFAULT, options.member)
    except InputError as error:  # circuits that cannot be
        notes.append(f"The torque over a turn was not computed: {error}.")
    else:
        panels[:0] = _torque_over_rotation_panels(run)
        notes += [] if run.converged else [f"Computation of the torque over a turn: {run.status}."]
    rows: list[Row] = [
        {
            "flank": row.contact,
            "mean_load": row.mean_load,
            "mean_load_without_friction": row.bare_load,
            "friction_loss_whole": row.loss,
            ("loss_by", "sliding across"): row.sliding_across,
            ("loss_by", "sliding along"): row.sliding_along,
            ("loss_by", "spin"): row.spin,
        }
        for row in found.by_contact
    ]
    names = [f"{row.contact}: {row.loss:.3g} W" for row in found.by_contact]
    lost, at = [row.loss for row in found.by_contact], [1.0 + k for k in range(len(names))]
    panels.append(Panel("who takes it", "friction loss / W", "", (Series("", lost, at, "bars"),), ordinate_names=names))
    caption = (
        "Panels: friction torque over the angle of the rotating part; over the friction coefficient, in the range of "
        f"lubricated contacts ({MEASURED[0]:g} to {MEASURED[1]:g}); over a change of all ball radii; loss on each flank."
    )
    drawn = "Friction torque over rotation, friction coefficient and ball size, and the loss on each flank"
    figure = Figure("friction", drawn, tuple(panels), caption, columns=2)
    losses = Table.from_rows("losses", "Friction losses by contact and cause", rows)
    return Section("friction", title, (Text(tuple(notes), bullets=True), figure, losses))


def _torque_over_rotation_panels(run: TransientRun) -> list[Panel]:
    """Return a list with the panel of friction torque over the angle of rotation: in total, and by groove contacts alone.

    ``run``: friction computed over time. The list is empty if this computation did not start.
    """
    h = run.history
    if not h.begun_step_count:
        return []
    angle = np.degrees(h.rotation_angle).tolist()
    series = (
        Series("total", angle, (1e3 * h.torque).tolist(), "line", bold=True),
        Series("contacts with the grooves", angle, (1e3 * h.groove_torque).tolist(), "line"),
    )
    x, y = "angle of the rotating part / deg", "friction torque / N mm"
    return [Panel("torque over the rotation", x, y, series, include_zero=True)]


def _torque_over_coefficient_panel(solved: StaticallySolvedPart, result: StaticResult) -> Panel:
    """Return the panel of friction torque over the friction coefficient, with the scene's value marked.

    ``solved``: the scene with its friction. ``result``: its static solution under the loads.
    """
    given = solved.friction
    values = np.geomspace(*MEASURED, 7)
    cases = [solved.case(result, replace(given, screw=mu, nut=mu, balls=None)) for mu in values]
    *torques, here = (1e3 * torque for torque in solved.torques([*cases, solved.case(result, given)]))
    this_scene = Series("this scene", [max(given.screw, given.nut)], [here], "markers")
    series = (Series("equal coefficient on screw and nut", values.tolist(), torques, bold=True), this_scene)
    title = "torque over the friction coefficient"
    return Panel(title, "coefficient of friction", "friction torque / N mm", series, log_axes="x", include_zero=True)


def _torque_over_ball_size_panel(solved: StaticallySolvedPart) -> Panel:
    """Return the panel of friction torque over a change of the radius of all balls, which changes the play.

    ``solved``: the scene with its friction. The static equilibrium is solved again for each radius.
    """
    scene, cases = solved.scene, []
    for play in PLAY:
        balls = replace(scene.errors.balls, oversize=scene.errors.balls.oversize + play)
        other = replace(scene, errors=replace(scene.errors, balls=balls))
        found = run_model(other, solved.model, replace(solved.options, estimate_beam_mesh_error=False))
        cases.append(solved.case(found, solved.friction, other))
    torques = [1e3 * torque for torque in solved.torques(cases)]
    series = (Series("friction coefficient of the scene", [1e6 * play for play in PLAY], torques, bold=True),)
    x, y = "change of the ball radius / um", "friction torque / N mm"
    return Panel("torque over the ball size", x, y, series, include_zero=True)
