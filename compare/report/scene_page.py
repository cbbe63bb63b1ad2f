"""``rollbench report SCENE``: a page on one scene, for a customer.

Its section on friction shows torque over a turn, losses, and the effect of coefficient and play.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, Refusal
from rollbench.compare.gate.user import references_from_file
from rollbench.compare.measure import LoadError, load_error
from rollbench.compare.models.answers import Answers, tangent_stiffness_at
from rollbench.compare.models.comparison import from_result
from rollbench.compare.models.load_cases import SolvedAxis, cycle_results, solve_any, solve_axis, solve_one
from rollbench.compare.models.model_form import FILE, ModelForm
from rollbench.compare.models.registry import DEFAULT, Options, default_model, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import QUANTITIES, Validated, validated_error
from rollbench.compare.quantities import count_of
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.store import path_in, shipped_store
from rollbench.compare.report.axis_page import page_of_axis
from rollbench.compare.report.parts import answers_table, notes_section, page_provenance, scene_text, source_files
from rollbench.compare.results.rows import answer_rows, expected_words, together_rows
from rollbench.compare.results.scene_json import case_json, cases_json
from rollbench.compare.results.view import make_view
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.sections.curves import load_curve, load_panel
from rollbench.compare.sections.fit import range_figure, range_table
from rollbench.compare.sections.sheets import sketch_scene
from rollbench.compare.studies.friction.answer import loss_rows, result_lines
from rollbench.compare.studies.friction.run import RunInTime, solve_run
from rollbench.compare.studies.friction.whole import MEASURED, StaticallySolved, drag_torques, friction_status
from rollbench.compare.text.solved import case_rows
from rollbench.lowfi.friction.whole.losses import CAUSES
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.friction.whole.torque import ONE_TURN
from rollbench.lowfi.statics.contacts import own_hertz
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.meshes.axis import Assembly
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, SIDES, Motion, Scene, Time
from rollbench.reports.content import Figure, LoadedScrew, Panel, Quantity, Row, Section, Series, Table, Text
from rollbench.reports.manifest import sha256
from rollbench.reports.scene_page import ScenePage

SKETCH = "The scene, to scale about the nut; hatched: where a 3D model holds it"


@contextmanager
def writing_to_folder(out: Path) -> Iterator[None]:
    """Turn errors of writing to the folder ``out`` into InputError, also if it holds files of something else."""
    from rollbench.reports.pages import check_target

    try:
        check_target(out)
        yield
    except (ValueError, OSError) as error:
        allowed = "a folder that is new, empty or an earlier report"
        raise ArgumentError("out", str(error), allowed, "choose another folder", str(out)) from None


def make_page(name: str, stores: Sequence[Path], file: Path | None = None) -> ScenePage:
    """Make the page of a scene, or of its load cases.

    Parameters
    ----------
    name
        Name or file of the scene.
    stores
        Folders with runs of the 3D reference.
    file
        File with loads instead of the 3D reference.

    Returns
    -------
    ScenePage
        The page.

    Raises
    ------
    InputError
        For a scene of another kind, and a reference of several sets; as Refusal if it does not solve.
    """
    described = catalogue.any_scene(name)
    sets = isinstance(described.parts if isinstance(described, DutyCycle) else described, Assembly)
    if sets and file is not None:
        raise ArgumentError("reference", str(file), "with a scene of one set", "leave it out", name)
    if isinstance(described, DutyCycle):
        return _page_of_cases(name, described, stores, file)
    if isinstance(described, Assembly):
        return page_of_axis(name, solve_axis(described, default_model(described), Options()), stores)
    return _page_of_scene(name, scene_file.single_set_or_raise(described, name), stores, file)


def _page_of_cases(name: str, cycle: DutyCycle, stores: Sequence[Path], file: Path | None) -> ScenePage:
    """Return the page of the load case with the highest pressure, headed by the results of all cases together."""
    solved = [solve_any(case.scene, default_model(case.scene), Options()) for case in cycle.cases]
    names = [case.name for case in cycle.cases]
    whole = cycle_results(cycle, solved)
    if whole.pressure is None:
        raise Refusal(name, "cases", "no case carries load, or converges", "see: rollbench solve")
    worst = whole.pressure.case
    one = solved[names.index(worst)]
    if isinstance(one, SolvedAxis):
        page = page_of_axis(name, one, stores)
    else:
        page = _page_of_scene(name, one.scene, stores, file, worst)
    data = cases_json(cycle, solved, whole)
    rows: list[Row] = [
        {Quantity(key, key, "", "s" if key == "case" else "g4"): value for key, value in row.items()}
        for row in case_rows(data["cases"])
    ]
    answers = together_rows(whole)
    life_said = " or ".join(f"{row.value} {row.unit}" for row in answers if row.quantity == "life L10") or "not known"
    table = Table.of("cases", "Load cases", rows, "Life of each case by itself; what follows is of the worst case.")
    lost = "".join(f" Case {one} has no loads: {status}." for one, status in whole.unsolved.items())
    cases = count_of(len(solved), "load case")
    return replace(
        page,
        title=cycle.title,
        subtitle=f"{cycle.name}, {cases}: {page.subtitle.partition(': ')[2]}; below, case {worst}",
        verdict=f"Of {cases} {worst} is the worst. {page.verdict} Life: {life_said}.{lost}",
        table=answers_table(answers, "Of all load cases"),
        parts=(Section("cases", "Load cases", (table, *filter(None, [page.table]))), *page.parts),
        results=data,
        view=make_view(cycle.title, solved, data, names, stores),
    )


def _page_of_scene(
    name: str, scene: Scene, stores: Sequence[Path], file: Path | None = None, case: str | None = None
) -> ScenePage:
    """Return the page of one load case."""
    study, warnings = Study(stores, scenes={scene.name: scene}), list[str]()

    given = None if file is None else references_from_file(file, scene, warnings.append, case=case)[0].found
    options = Options()
    one = solve_one(scene, DEFAULT, options)
    result, answers, worth = one.result, one.answers, one.expected
    if answers is None or worth is None:
        raise Refusal(name, "scene", result.status, "see: rollbench solve")
    tangent = tangent_stiffness_at(scene, scene.nut.position, DEFAULT, options)
    stored = study.reference(scene.name)
    judged = [
        v for q in QUANTITIES if (v := validated_error(study, scene.name, DEFAULT, q, from_result(result))) is not None
    ]
    text, data = scene_text(name), case_json(one)
    sections = (
        Section("scene", "The scene", (sketch_scene(scene, "sketch", SKETCH),)),
        _loads_section(scene, result, [reference for reference in (given, stored) if reference is not None]),
        _stiffness_section(answers, tangent),
        *filter(None, [friction_section(scene, result, options)]),
        _error_section(scene, worth, judged, stored, None if given is None else compare_with_reference(given, result)),
        notes_section(result, warnings),
    )
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure, friction and life by rollbench, model {DEFAULT}",
        verdict_sentence(answers, worth, judged, stored, None if given is None else compare_with_reference(given, result)),
        (),
        _picture_of_scene(scene, result),
        sections,
        _scene_provenance(name, scene, text, stored, file),
        text,
        data,
        _hash_files(scene, stored, stores),
        warnings,
        make_view(scene.title, [one], data, (), stores, given),
        table=answers_table(
            answer_rows(one), f"Answers of model {DEFAULT}, each with the error to expect", expected_words(worth)
        ),
    )


@dataclass(frozen=True)
class Against:
    """Comparison of a result with the user's reference."""

    #: Errors of the loads.
    error: LoadError
    #: Largest stated uncertainty of the reference [% of the mean load].
    uncertainty: float
    #: Statement of the reference about itself.
    stated: str

    @property
    def largest_error(self) -> str:
        """Return the largest error as a clause."""
        e = self.error
        return f"loads are off by up to {e.max_percent:.2f} % of their mean (ball {e.ball} {e.side})"


def compare_with_reference(given: Reference, result: StaticResult) -> Against:
    """Compare the loads of a result with the user's reference."""
    error = load_error(result.load, given.load, given.contacts)
    return Against(error, uncertainty_percent(given), given.stated)


def verdict_sentence(
    answers: Answers, worth: ModelForm, judged: Sequence[Validated], reference: Reference | None, given: Against | None
) -> str:
    """Return the main result in one sentence: highest pressure, static safety, and measured or expected error."""
    worst, safety = answers.loads.worst, answers.loads.safety
    if worst is None or safety is None:
        return "No contact carries load."
    text = (
        f"The most pressed contact (ball {worst.ball} {worst.side}) carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {safety.factor:.2g}"
    )
    if given is not None:
        return f"{text}; {given.stated}, {given.largest_error}."
    if judged and reference is not None:
        v = judged[0]
        bar = v.bar + (f"; {reference.unsettled}" if reference.unsettled else "")
        return (
            f"{text}; measured against the 3D reference, loads are off by up to {abs(v.error):.2f} % of their mean ({bar})."
        )
    if worth.percent is None:
        return f"{text}; the error of these loads is not covered by what was compared with the 3D reference."
    return f"{text}; an error of up to {worth.percent:.1f} % of the mean load is to be expected of scenes like it."


def _loads_section(scene: Scene, result: StaticResult, references: Sequence[Reference]) -> Section:
    """Return the section of all contact loads with their pressures, next to those of the references."""
    panels = []
    pressure = 1e-6 * own_hertz(scene, specimen(scene, ball_layout(scene), result.member)).pressure(result.load)
    for s, side in enumerate(SIDES[:2]):
        if not (result.load[:, s] > 0.0).any():
            continue
        series = [load_curve(r.label, r, s, "markers", bar=r.uncertainty) for r in references]
        panels.append(
            load_panel(f"screw's flank {side}", load_curve(DEFAULT, result, s, emphasis=True), *series, zero=True)
        )
    rows: list[Row] = []
    for i, s in zip(*np.nonzero(result.load > 0.0), strict=True):
        row: Row = {
            Quantity("ball", "ball"): int(i) + 1,
            Quantity("side", "flank", "", "s"): SIDES[int(s)],
            Quantity("load", "load", "N", ".1f"): float(result.load[i, s]),
        }
        for reference in references:
            key = "given" if reference.stated else "reference"
            row[Quantity(key, reference.label, "N", ".1f")] = float(reference.load[i, s])
        row[Quantity("angle", "contact angle", "deg", ".2f")] = float(np.degrees(result.contact_angle[i, s]))
        row[Quantity("pressure", "peak pressure", "MPa", ".0f")] = float(pressure[i, s])
        rows.append(row)
    items: list[Figure | Table] = [Figure("loads", "Contact loads, ball by ball", tuple(panels))] if panels else []
    items.append(Table.of("contacts", "Every loaded contact", rows, "Peak pressure: Hertz, each contact's own radii."))
    return Section("loads", "Loads and pressures", items)


def _stiffness_section(answers: Answers, tangent: Tangent) -> Section:
    """Return the section on rigidities by formulas and model, and the tangent stiffness at the nut."""
    three = answers.rigidities
    names = (
        "contacts alone (R_b/t), formula at the nominal contact angle",
        "contacts and bodies (R_nu), formula at the nominal contact angle",
        "this model, secant (R_nu,ar)",
        "this model, tangent at this load",
    )
    values = (None,) * 3 if three is None else (three.contacts, three.bodies, three.unequal)
    rows: list[Row] = [
        {
            Quantity("name", "axial rigidity", "", "s"): name,
            Quantity("value", "", "N/um"): None if value is None else 1e-6 * value,
        }
        for name, value in zip(names, (*values, answers.tangent), strict=True)
    ]
    first = Table.of("rigidity", "Axial rigidities: formulas of ISO 3408-4, and of this model", rows)
    if tangent.status != "converged":
        return Section("stiffness", "Stiffness", (first, Text((f"Tangent stiffness: {tangent.status}.",))))
    cells: list[Row] = [
        {
            Quantity("freedom", "force or moment", "", "s"): name,
            **{Quantity(other, other): float(tangent.matrix[i, k]) for k, other in enumerate(FREEDOMS)},
        }
        for i, name in enumerate(FREEDOMS)
    ]
    note = "Screw at the nut's centre, tangent; rows and columns in N, N m, m and rad."
    return Section("stiffness", "Stiffness", (first, Table.of("tangent", "Stiffness 6 x 6", cells, note)))


def _error_section(
    scene: Scene, worth: ModelForm, judged: Sequence[Validated], reference: Reference | None, given: Against | None = None
) -> Section:
    """Return the section of errors: measured with u_val, expected, and whether the scene is in the compared range."""
    items: list[Text | Table | Figure] = []
    if given is not None:
        text = f"{given.stated[:1].upper()}{given.stated[1:]}: {given.largest_error}, "
        text += f"uncertain by up to {given.uncertainty:.2f} %."
        items.append(Text((text,)))
    if judged and reference is not None:
        levels = ", ".join(str(run.level) for run in reference.runs)
        rows: list[Row] = [
            {
                "quantity": v.quantity,
                Quantity("error", "error", "%", "+.2f"): v.error,
                Quantity("grid", "grid", "%", ".2f"): v.grid,
                Quantity("choices", "modelling choices", "%", ".2f"): v.choices,
                Quantity("inputs", "input tolerances", "%", ".2f"): v.inputs,
                Quantity("u", "u_val", "%", ".2f"): v.combined,
            }
            for v in judged
        ]
        note = (
            f"Against the 3D reference on mesh levels {levels}. Contact loads: the worst contact, in per cent of the mean "
            "load. u_val combines the three by the root of the sum of squares (ASME V&V 20); choices of the reference were "
            "varied on other scenes unless this is one of them."
        )
        items.append(Table.of("measured", "Measured error and its uncertainty", rows, note))
    else:
        items.append(Text(("Not measured: no run of the 3D reference is stored for this scene (rollbench mesh-study).",)))
    expected = expected_words(worth)
    items.append(Text((expected[:1].upper() + expected[1:] + ".",)))
    try:
        items += [range_table(scene), range_figure(scene)]
    except ValueError as error:
        items.append(Text((f"The scene cannot be placed among the compared ones: {error}.",)))
    return Section("error", "How far these numbers may be trusted", items)


def _picture_of_scene(scene: Scene, result: StaticResult) -> LoadedScrew:
    loaded = result.load > 0.0
    arrows = result.contact_point[loaded], (result.force_direction * result.load[..., None])[loaded]
    caption = "Balls are coloured by their load; arrows are the contact forces on them."
    return LoadedScrew("picture", "The scene under load", scene, result.load, *arrows, caption)


def _hash_files(scene: Scene, reference: Reference | None, stores: Sequence[Path]) -> dict[str, str]:
    """Return SHA-256 by file: sources, data of the error estimate, and the reference runs that were used."""
    paths = [shipped_store() / FILE]
    for run in () if reference is None else reference.runs:
        paths += [p for store in stores if (p := path_in(store, scene, run)).exists()][:1]
    return source_files() | {path.name: sha256(path.read_bytes()) for path in paths if path.exists()}


def _scene_provenance(name: str, scene: Scene, text: str, reference: Reference | None, file: Path | None) -> dict[str, str]:
    """Return the provenance of the page, with that of the references."""
    out = page_provenance(name, scene, text, DEFAULT)
    if reference is not None:
        runs = "; ".join(
            f"level {r.level} of {r.date}, rollbench {r.versions.get('rollbench', '?')}" for r in reference.runs
        )
        out["3D reference"] = runs
    if file is not None:
        out["reference"] = f"{file.name}, SHA-256 {sha256(file.read_bytes())}"
    return out


#: Number of steps of a run over one turn, if the scene states no run.
STEPS = 24

#: Oversizes of the ball radius relative to the scene [m], at the points of the figure.
PLAY = (-10e-6, -5e-6, -2e-6, 0.0, 2e-6)


def friction_section(scene: Scene, result: StaticResult, options: Options) -> Section | None:
    """Return the section on friction; None if the scene has no friction coefficient."""
    if scene.friction is None:
        return None
    motion = scene.motion or ONE_TURN
    bare = run_model(replace(scene, loads=()), DEFAULT, options) if scene.loads else result
    solved = StaticallySolved(scene, DEFAULT, options, scene.friction, motion, bare)
    try:
        state = friction_state(scene, result, scene.friction, motion, options.member)
    except ValueError as error:  # balls that overlap by their random sizes
        return Section("friction", "Friction", (Text((f"No friction: {error}.",)),))
    if not state.settled:
        return Section("friction", "Friction", (Text((f"No friction: {friction_status(state)}.",)),))
    (drag,) = drag_torques(scene, [state], [scene.friction], bare, options)
    lines = result_lines(motion, state, (drag.torque, drag.reason or drag.note))
    panels, notes = [_over_coefficient(solved, result), _over_play(solved)], [f"{label}: {text}." for label, text in lines]
    try:
        run = solve_run(
            replace(scene, time=_time_of_one_turn(scene, motion)), scene.friction, motion, DEFAULT, options.member
        )
    except InputError as error:  # circuits that cannot be
        notes.append(f"No run in time: {error}.")
    else:
        panels[:0] = _over_turn(run)
        notes += [] if run.converged else [f"Run in time: {run.status}."]
    rows: list[Row] = [
        {
            Quantity("contact", "contact", "", "s"): row["contact"],
            Quantity("loss_W", "loss", "W", ".3g"): row["loss_W"],
            **{Quantity(cause, cause.replace("_", " "), "W", ".3g"): row[cause] for cause in CAUSES},
        }
        for row in loss_rows(state)
    ]
    caption = (
        "Grooves and neighbours over the angle of the turning part; friction torque over the coefficients "
        f"of lubricated contacts, {MEASURED[0]:g} to {MEASURED[1]:g}, and over ball radii near the scene's."
    )
    return Section(
        "friction",
        "Friction",
        (
            Text(tuple(notes), bullets=True),
            Figure("friction", "Friction torque over the turn, the coefficient and the play", tuple(panels), caption, 3),
            Table.of("losses", "Losses by contact and cause", rows),
        ),
    )


def _time_of_one_turn(scene: Scene, motion: Motion) -> Time:
    """Return the scene's time span, or one turn; for a bearing the angle at which the ball pattern repeats."""
    angle = 2.0 * np.pi / (scene.ball_count if scene.track.lead == 0.0 else 1.0)
    return scene.time or Time(duration=abs(angle / motion.speed), steps=STEPS, goal=1.0, output="torque")


def _over_turn(run: RunInTime) -> list[Panel]:
    """Return the panel of friction torque over angle, total and of the grooves; none if the run did not start."""
    h = run.history
    if not h.begun:
        return []
    angle = np.degrees(h.turned).tolist()
    series = (
        Series("all", angle, (1e3 * h.torque).tolist(), "line", emphasis=True),
        Series("grooves", angle, (1e3 * h.groove_torque).tolist(), "line"),
    )
    return [Panel("over the turn", "angle / deg", "friction torque / N mm", series, zero=True)]


def _over_coefficient(solved: StaticallySolved, result: StaticResult) -> Panel:
    """Return the panel of friction torque over the friction coefficient, with the scene's value marked."""
    given = solved.friction
    values = np.geomspace(*MEASURED, 7)
    torques = [1e3 * solved.torque(result, replace(given, screw=mu, nut=mu, balls=None)) for mu in values]
    this_scene = Series("this scene", [max(given.screw, given.nut)], [1e3 * solved.torque(result, given)], "markers")
    series = (Series("equal coefficients", values.tolist(), torques, emphasis=True), this_scene)
    return Panel("over the coefficient", "coefficient of friction", "friction torque / N mm", series, log="x", zero=True)


def _over_play(solved: StaticallySolved) -> Panel:
    """Return the panel of friction torque over a change of the ball radius."""
    scene, torques = solved.scene, []
    for play in PLAY:
        balls = replace(scene.errors.balls, oversize=scene.errors.balls.oversize + play)
        other = replace(scene, errors=replace(scene.errors, balls=balls))
        found = run_model(other, solved.model, replace(solved.options, discretisation=False))
        torques.append(1e3 * solved.torque(found, solved.friction, other))
    series = (Series("this coefficient", [1e6 * play for play in PLAY], torques, emphasis=True),)
    return Panel("over the play", "balls larger in radius by / um", "friction torque / N mm", series, zero=True)
