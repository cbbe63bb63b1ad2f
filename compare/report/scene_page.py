"""``rollbench report SCENE``: one page on a scene that may be sent to a customer."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.files import need_writable, replace_file
from rollbench.compare.gate.user import judged_by
from rollbench.compare.measure import LoadError, load_error
from rollbench.compare.models.answers import Answers, tangent_of
from rollbench.compare.models.comparison import from_result
from rollbench.compare.models.load_cases import solve_one, together
from rollbench.compare.models.model_form import FILE, ModelForm
from rollbench.compare.models.registry import DEFAULT, Options
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import QUANTITIES, Validated, validated
from rollbench.compare.provenance import SOURCES, commit, sources_hash
from rollbench.compare.quantities import count_of
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.grid_summary import uncertainty_percent
from rollbench.compare.reference.store import path_in, shipped_store
from rollbench.compare.results.scene_json import case_json, cases_json
from rollbench.compare.running import libraries
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.sections.applicability import range_figure, range_table
from rollbench.compare.sections.curves import load_panel, loads
from rollbench.compare.sections.sketch import sketch_of
from rollbench.compare.text.cases import case_rows, together_entries
from rollbench.compare.text.entries import entries
from rollbench.lowfi.statics.contacts import own_hertz
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.tangent import Tangent
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, SIDES, Scene
from rollbench.reports.content import Figure, LoadedScrew, Quantity, Row, Section, Table, Text
from rollbench.reports.manifest import sha256
from rollbench.reports.scene_page import ScenePage

SKETCH = "The scene, to scale about the nut; hatched: where a 3D model holds it"
LIBRARIES = ("numpy", "scipy", "numba")


def make_page(name: str, out: Path, store: Path, reference: Path | None = None) -> ScenePage:
    """Solve a scene by the default model, set it beside a stored reference where there is one, or beside a user's own, and
    write the page.

    Raises InputError for a scene of another kind and a folder that holds what no report wrote, Refusal where
    the scene does not solve.
    """
    from rollbench.reports.scene_page import render

    with replaced(out):
        need_writable(out / "index.html")
    page = page_of(name, (store, shipped_store()), reference)
    replace_file(out / "index.html", render(page))
    return page


@contextmanager
def replaced(out: Path) -> Iterator[None]:
    """Write a report into the folder ``out`` inside. Raises InputError where it holds what no report wrote, or cannot be
    written."""
    from rollbench.reports.pages import check_target

    try:
        check_target(out)
        yield
    except (ValueError, OSError) as error:
        allowed = "a folder that is new, empty or an earlier report"
        raise ArgumentError("out", str(error), allowed, "choose another folder", str(out)) from None


def page_of(name: str, stores: Sequence[Path], file: Path | None = None) -> ScenePage:
    """The page of a scene, or of its load cases; file: of the user's own reference. Raises InputError and Refusal as
    `make_page`."""
    described = catalogue.any_scene(name)
    if not isinstance(described, DutyCycle):
        return _page_of_scene(name, scene_file.whole(described, name), stores, file)
    return _page_of_cases(name, described, stores, file)


def _page_of_cases(name: str, cycle: DutyCycle, stores: Sequence[Path], file: Path | None) -> ScenePage:
    """The page of the most pressed load case, with what all cases say together above it."""
    scenes = {case.name: scene_file.whole(case.scene, name) for case in cycle.cases}
    solved = [solve_one(scene, DEFAULT, Options()) for scene in scenes.values()]
    whole = together(cycle, solved)
    if whole.pressure is None:
        raise Refusal(name, "cases", "no case carries load, or converges", "see: rollbench solve")
    worst = whole.pressure.case
    page = _page_of_scene(name, scenes[worst], stores, file, worst)
    data = cases_json(cycle, solved, whole)
    rows: list[Row] = [
        {Quantity(key, key, "", "s" if key == "case" else "g4"): value for key, value in row.items()}
        for row in case_rows(data["cases"])
    ]
    answers = together_entries(whole)
    table = Table.of("cases", "Load cases", rows, "Life of each case by itself; what follows is of the worst case.")
    lost = "".join(f" Case {one} has no loads: {status}." for one, status in whole.unsolved.items())
    life_said, cases = dict(answers)["life"], count_of(len(solved), "load case")
    return replace(
        page,
        title=cycle.title,
        subtitle=f"{cycle.name}, {cases}: {page.subtitle.partition(': ')[2]}; below, case {worst}",
        verdict=f"Of {cases} {worst} is the worst. {page.verdict} Life: {life_said}.{lost}",
        answers=[*answers, *((f"{worst}: {label}", text) for label, text in page.answers)],
        parts=(Section("cases", "Load cases", (table,)), *page.parts),
        results=data,
    )


def _page_of_scene(
    name: str, scene: Scene, stores: Sequence[Path], file: Path | None = None, case: str | None = None
) -> ScenePage:
    """The page of one load case of the file or shipped scene of that name."""
    study, warnings = Study(stores, scenes={scene.name: scene}), list[str]()
    from rollbench.compare.sections.own_friction import section as friction_section

    given = None if file is None else judged_by(file, scene, warnings.append, case=case)[0].found
    options = Options()
    one = solve_one(scene, DEFAULT, options)
    result, answers, worth = one.result, one.answers, one.expected
    if answers is None or worth is None:
        raise Refusal(name, "scene", result.status, "see: rollbench solve")
    tangent = tangent_of(scene, scene.nut.position, DEFAULT, options)
    stored = study.reference(scene.name)
    judged = [v for q in QUANTITIES if (v := validated(study, scene.name, DEFAULT, q, from_result(result))) is not None]
    text = _scene_text(name)
    sections = (
        Section("scene", "The scene", (sketch_of(scene, "sketch", SKETCH),)),
        _loads(scene, result, [reference for reference in (given, stored) if reference is not None]),
        _stiffness(answers, tangent),
        *filter(None, [friction_section(scene, result, options)]),
        _error(scene, worth, judged, stored, None if given is None else against(given, result)),
        _notes(result, warnings),
    )
    return ScenePage(
        scene.title,
        f"{scene.name}: contact loads, stiffness, pressure, friction and life by rollbench, model {DEFAULT}",
        verdict(answers, worth, judged, stored, None if given is None else against(given, result)),
        entries(one),
        _picture(scene, result),
        sections,
        _provenance(name, scene, text, stored, file),
        text,
        case_json(one),
        _files(scene, stored, stores),
        warnings,
    )


@dataclass(frozen=True)
class Against:
    """What a user's own reference says: largest error [% of the mean load] and its contact, the uncertainty that the
    reference states of any contact [% of the mean load], and what it says of itself."""

    error: LoadError
    uncertainty: float
    stated: str

    @property
    def words(self) -> str:
        """The largest error in words."""
        e = self.error
        return f"loads are off by up to {e.max_percent:.2f} % of their mean (ball {e.ball} {e.side})"


def against(given: Reference, result: StaticResult) -> Against:
    """A result held against a user's own reference."""
    error = load_error(result.load, given.load, given.contacts)
    return Against(error, uncertainty_percent(given), given.stated)


def verdict(
    answers: Answers, worth: ModelForm, judged: Sequence[Validated], reference: Reference | None, given: Against | None
) -> str:
    """The answer in one sentence: worst pressure and safety, and how far they may be trusted."""
    worst, safety = answers.loads.worst, answers.loads.safety
    if worst is None or safety is None:
        return "No contact carries load."
    text = (
        f"The most pressed contact (ball {worst.ball} {worst.side}) carries {worst.force:.0f} N at "
        f"{1e-6 * worst.pressure:.0f} MPa, static safety {safety.factor:.2g}"
    )
    if given is not None:
        return f"{text}; {given.stated}, {given.words}."
    if judged and reference is not None:
        v = judged[0]
        bar = v.bar + (f"; {reference.unsettled}" if reference.unsettled else "")
        return (
            f"{text}; measured against the 3D reference, loads are off by up to {abs(v.error):.2f} % of their mean ({bar})."
        )
    if worth.percent is None:
        return f"{text}; the error of these loads is not covered by what was compared with the 3D reference."
    return f"{text}; an error of up to {worth.percent:.1f} % of the mean load is to be expected of scenes like it."


def _loads(scene: Scene, result: StaticResult, references: Sequence[Reference]) -> Section:
    """Figure and table of all contacts with their pressures, beside those of references."""
    panels = []
    pressure = 1e-6 * own_hertz(scene, specimen(scene, ball_layout(scene), result.member)).pressure(result.load)
    for s, side in enumerate(SIDES[:2]):
        if not (result.load[:, s] > 0.0).any():
            continue
        series = [loads(r.label, r, s, "markers", bar=r.uncertainty) for r in references]
        panels.append(load_panel(f"screw's flank {side}", loads(DEFAULT, result, s, emphasis=True), *series, zero=True))
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


def _stiffness(answers: Answers, tangent: Tangent) -> Section:
    """Rigidities by formulas and by the model, and the tangent stiffness at the nut."""
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


def _error(
    scene: Scene, worth: ModelForm, judged: Sequence[Validated], reference: Reference | None, given: Against | None = None
) -> Section:
    """Measured error with u_val where a reference is stored, expected error, and where the scene lies."""
    from rollbench.compare.text.entries import model_form_text

    items: list[Text | Table | Figure] = []
    if given is not None:
        text = f"{given.stated[:1].upper()}{given.stated[1:]}: {given.words}, uncertain by up to {given.uncertainty:.2f} %."
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
    expected = model_form_text(worth)
    items.append(Text((expected[:1].upper() + expected[1:] + ".",)))
    try:
        items += [range_table(scene), range_figure(scene)]
    except ValueError as error:
        items.append(Text((f"The scene cannot be placed among the compared ones: {error}.",)))
    return Section("error", "How far these numbers may be trusted", items)


def _notes(result: StaticResult, warnings: Sequence[str] = ()) -> Section:
    """Warnings, assumptions, what is left out."""
    items: list[Text | Table | Figure] = []
    warned = (*warnings, *result.warnings)
    for head, lines in (("Warning", warned), ("Assumed", result.assumed), ("Left out", result.left_out)):
        if lines:
            items.append(Text(tuple(f"{head}: {line}" for line in lines), bullets=True))
    return Section("assumptions", "Assumptions", items)


def _picture(scene: Scene, result: StaticResult) -> LoadedScrew:
    loaded = result.load > 0.0
    arrows = result.contact_point[loaded], (result.force_direction * result.load[..., None])[loaded]
    caption = "Balls are coloured by their load; arrows are the contact forces on them."
    return LoadedScrew("picture", "The scene under load", scene, result.load, *arrows, caption)


def _scene_text(name: str) -> str:
    return catalogue.scene_text(name) if name in catalogue.scene_names() else scene_file.read_text(name)


def _files(scene: Scene, reference: Reference | None, stores: Sequence[Path]) -> dict[str, str]:
    """SHA-256 of the sources, of the points of the estimate, and of every run of the reference that was used."""
    out = {SOURCES: sources_hash()}
    paths = [shipped_store() / FILE]
    for run in () if reference is None else reference.runs:
        paths += [p for store in stores if (p := path_in(store, scene, run)).exists()][:1]
    return out | {path.name: sha256(path.read_bytes()) for path in paths if path.exists()}


def _provenance(name: str, scene: Scene, text: str, reference: Reference | None, file: Path | None) -> dict[str, str]:
    out = {
        "scene": f"{Path(name).name}, SHA-256 {sha256(text)}",
        "rollbench": f"{__version__}, commit {commit()}",
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "libraries": libraries(LIBRARIES),
        "Python": f"{platform.python_version()}, {platform.system()} {platform.machine()}",
        "model": f"{DEFAULT}; nothing in it is fitted to a 3D solution",
    }
    if reference is not None:
        runs = "; ".join(
            f"level {r.level} of {r.date}, rollbench {r.versions.get('rollbench', '?')}" for r in reference.runs
        )
        out["3D reference"] = runs
    if file is not None:
        out["reference"] = f"{file.name}, SHA-256 {sha256(file.read_bytes())}"
    if scene.source:
        out["source"] = scene.source
    return out
