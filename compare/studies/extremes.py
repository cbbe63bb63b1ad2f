"""Numerical stability: scenes that are hard to solve, solved by several models.

The scenes are in `hard_scenes`. A test (`tests/property/test_dense_oracle.py`) solves those with up to 40 balls by its own
equations and compares the loads. For rollers, the load-displacement law of every slice is checked here.

A publication brings further formulations, by the `formulations` of its `Case`.

Campaigns of random scenes are run by ``python -m tests.campaign`` of the repository; this module reads their records.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.measure import error_percent
from rollbench.compare.models.many import solve_many
from rollbench.compare.models.registry import MODELS
from rollbench.compare.quantities import json_number
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.studies.extreme_cases import CONVERGED, HardScene, hard_scenes
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.rollers import slice_middles, tapered_bearing_of_row
from rollbench.lowfi.statics.axis.solve import solve_assembly, solve_assembly_with_elastic_bodies
from rollbench.lowfi.statics.result import AxisResult, SetResult, StaticResult
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.static import solve_elastic, solve_static
from rollbench.lowfi.statics.summary import BALANCE
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.reports.content import Cell, Row

#: Name of the formulation by the energy solver.
ENERGY = "energy solver"

#: Models of elastic bodies by the name of their formulation; all must solve the hard-to-solve scenes.
BACKENDS = {m.label: m.name for m in MODELS.values() if m.solves_hard_scenes}

#: Largest number of balls for which formulations with elastic bodies are attempted.
ELASTIC_LIMIT = 250

#: Allowed difference between a roller slice's line load and its load-displacement law, over the largest line load.
SLICES = 1e-9

#: Difference between the loads of two formulations below which they count as the same solution [% of the largest load].
SAME = 1e-4


@dataclass(frozen=True)
class FormulationOutcome:
    """Outcome of one attempt to solve a hard-to-solve scene by one formulation of the equations."""

    #: Name of the hard-to-solve scene.
    case: str
    #: Group of the scene in the stability table.
    group: str
    #: Name of the formulation of the equations, one of `formulations`.
    formulation: str
    #: Status that the solver reported, or why the scene was not attempted.
    status: str
    #: Status that the solver should report: "converged", or the status that names a rigid motion that nothing resists.
    expected: str
    #: Whether the solver converged.
    converged: bool
    #: Number of iterations of the solver.
    iterations: int = 0
    #: Largest unbalanced force as a fraction of the largest force; None if the scene was not solved or has no force.
    residual: float | None = None
    #: Smallest ``residual`` that double precision allows; 0 for all formulations but the energy solver.
    round_off_bound: float = 0.0
    #: Run time of set-up and solution [s].
    seconds: float = 0.0
    #: Number of unknowns of the formulation.
    unknowns: int = 0
    #: Largest difference between contact loads by the formulation and by the energy solver with the same beam nodes [% of
    #: the largest load]; None unless both converged.
    difference_percent: float | None = None
    #: Short form of ``status``, followed by warnings and remarks.
    reason: str = ""

    @property
    def is_formulation_applicable(self) -> bool:
        """Whether the formulation can be applied to the scene and was tried."""
        return not self.status.startswith("not attempted")


# --- solution of the hard-to-solve scenes


#: Function that solves a hard-to-solve scene by the formulation of the equations with the given name.
Formulation = Callable[[HardScene, str], FormulationOutcome]


def formulations_of_cases() -> dict[str, Formulation]:
    """Return the formulations of the equations that publications bring, by their names."""
    brought = [case.import_object(case.formulations) for case in all_cases() if case.formulations]
    return {name: solve for of_case in brought for name, solve in of_case.items()}


def formulations() -> tuple[str, ...]:
    """Return the names of all formulations of the equations."""
    return (ENERGY, *BACKENDS, *formulations_of_cases())


def solve_hard_scene_by_formulation(hard_scene: HardScene, formulation: str) -> FormulationOutcome:
    """Solve one hard-to-solve scene by one formulation; the outcome also states a failure of the solver.

    Parameters
    ----------
    hard_scene
        The hard-to-solve scene.
    formulation
        Name of the formulation, one of `formulations`.

    Returns
    -------
    FormulationOutcome
        Status, residual and run time of the solution, and difference of its contact loads from the energy solver's.
    """
    if formulation in BACKENDS:
        return _outcome_with_elastic_bodies(hard_scene, formulation)
    if formulation != ENERGY:
        return formulations_of_cases()[formulation](hard_scene, formulation)
    begin, scene = perf_counter(), hard_scene.scene
    result = solve_assembly(scene) if isinstance(scene, Assembly) else solve_static(scene)
    row = _outcome_from_result(hard_scene, ENERGY, result, begin)
    return replace(row, difference_percent=0.0 if row.converged else None)


def _outcome_with_elastic_bodies(hard_scene: HardScene, formulation: str) -> FormulationOutcome:
    """Solve a hard-to-solve scene by a model with elastic bodies, and return the outcome.

    ``formulation``: a key of `BACKENDS`. The model is not applied to scenes whose dimensions leave no solid body (no land
    between grooves, no wall), to scenes with more than `ELASTIC_LIMIT` balls, which would take minutes, and to scenes with
    rollers only.
    """
    begin, scene = perf_counter(), hard_scene.scene
    try:
        if scene.ball_count > ELASTIC_LIMIT:
            raise ValueError(
                f"the scene has {scene.ball_count} balls: models with elastic bodies are applied to "
                f"at most {ELASTIC_LIMIT}, to save time"
            )
        if not scene.ball_count:
            raise ValueError(
                "a shaft with only roller bearings: models with elastic bodies need at least one nut or ball bearing, as "
                "otherwise only the shaft's beam is elastic"
            )
        solve: Any = solve_assembly_with_elastic_bodies if isinstance(scene, Assembly) else solve_elastic
        result = solve(scene, backend=LADDER[BACKENDS[formulation]])
    except ValueError as error:
        status, spent = f"not attempted: {error}", perf_counter() - begin
        return outcome_with_status(hard_scene, formulation, status, seconds=spent, reason=status)
    return _outcome_from_result(hard_scene, formulation, result, begin)


def _outcome_from_result(
    hard_scene: HardScene, formulation: str, result: StaticResult | AxisResult, start_time: float
) -> FormulationOutcome:
    """Return the outcome of a formulation from its static result, without comparing loads with the energy solver's.

    ``start_time``: value of ``perf_counter`` [s] at which the solution began.
    """
    status, s = _why_not_in_equilibrium(result) or result.status, result.solver
    return outcome_with_status(
        hard_scene,
        formulation,
        status,
        iterations=s.iterations,
        residual=json_number(s.residual),
        round_off_bound=s.round_off_bound,
        seconds=perf_counter() - start_time,
        unknowns=s.unknowns,
        reason="; ".join((first_clause_of_status(status), *result.warnings)),
    )


def outcome_with_status(hard_scene: HardScene, formulation: str, status: str, **found: Any) -> FormulationOutcome:
    """Return the outcome of a formulation for a hard-to-solve scene with a given status.

    ``found``: values of further fields of `FormulationOutcome`, by name of the field.
    """
    names = hard_scene.name, hard_scene.table_group, formulation
    return FormulationOutcome(*names, status, hard_scene.expected_status, status == CONVERGED, **found)


def _why_not_in_equilibrium(result: StaticResult | AxisResult) -> str:
    """Return why a result that is reported as converged is no equilibrium; an empty text if it is an equilibrium.

    The checks are that all numbers are finite, that the residual is small, that forces and moments balance, and that the
    slices of rollers follow their load-displacement law.
    """
    if not result.converged:
        return ""
    s, balance = result.solver, result.equilibrium
    loads = [s.loads for s in result.sets] if isinstance(result, AxisResult) else [result.load]
    if not all(np.isfinite(x).all() for x in (*loads, result.centreline)):
        return "claims convergence, but loads or displacements are not finite"
    if not s.residual <= max(ACCEPTED, s.round_off_bound):
        return f"claims convergence, but the residual is {s.residual:.1e}"
    if balance is None or not balance.largest <= BALANCE:
        return "claims convergence, but forces and moments on the screw do not balance"
    if isinstance(result, AxisResult):
        if any(not h.residual <= BALANCE for h in result.housings):
            return "claims convergence, but forces and moments on a housing do not balance"
        for row in result.sets if result.model == "lin" else ():
            if roller_slice_law_residual(row, result) > SLICES:
                return f"claims convergence, but slice loads of {row.of.name} do not follow from their approach"
    return ""


def roller_slice_law_residual(row: SetResult, result: AxisResult) -> float:
    """Return the largest deviation of a roller slice's line load from its load-approach law, over the largest line load.

    ``row``: solved row of tapered rollers; ``result``: solution of the shaft. The approach of a slice follows from the
    displacements of cone and cup; deviations that round-off of these displacements explains do not count. Zero for a row of
    balls, and for rollers without load.
    """
    parts, lines = row.of.parts, row.line_loads
    if not isinstance(parts, RollerRow) or lines is None or not lines.any():
        return 0.0
    bearing, sign, angle = tapered_bearing_of_row(parts), 1.0 if row.of.thrust == "+z" else -1.0, parts.cup_angle
    azimuth = parts.phase + 2.0 * np.pi * np.arange(parts.count) / parts.count
    along = slice_middles(parts.length, parts.slices)
    out = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(parts.count)], axis=1)[:, None, :]
    axis, reach = np.array([0.0, 0.0, sign]), bearing.apex_distance * np.sin(angle) + along[:, None] * np.sin(angle)
    at = reach * out - along[:, None] * np.cos(angle) * axis
    normal = np.cos(angle) * out + np.sin(angle) * axis
    shaft = result.centreline[int(np.abs(result.centreline_z - row.of.position).argmin())]
    moved = shaft - row.outer
    approach = np.sum(normal * (moved[:3] + np.cross(moved[3:], at)), axis=-1) - along**2 / parts.crown
    law = bearing.approach_law()
    edge = np.exp(law.g / law.s - 4.0)  # from here on the law goes on along its tangent
    most = law.approach(edge)
    beyond = np.maximum(approach - most, 0.0)
    expected = law.line_load(np.clip(approach, 0.0, most)) + law.stiffness_per_length(edge) * beyond
    largest = float(np.abs([*shaft[:3], *row.outer[:3]]).max())
    noise = 64.0 * np.finfo(float).eps * largest * law.stiffness_per_length(lines).max()
    return float(np.abs(expected - lines).max() / (lines.max() + noise / SLICES))


def largest_load_difference(load: Array, reference_load: Array) -> float:
    """Return the largest difference between the contact loads of two solutions [% of the largest ``reference_load``].

    ``load`` and ``reference_load``: contact loads [N], arrays of the same shape.
    """
    top = float(reference_load.max(initial=0.0))
    change = float(np.abs(load - reference_load).max())
    return float(np.abs(error_percent(change, 0.0, top))) if top > 0.0 else 0.0


def first_clause_of_status(status: str) -> str:
    """Return the first clause of a solver's status, or the first two if the status begins with "not held: "."""
    parts = status.split(": ")
    return ": ".join(parts[:2]) if parts[0] == "not held" else status.split(" (")[0]


def _solve_by_all_formulations(hard_scene: HardScene) -> list[FormulationOutcome]:
    """Solve a hard-to-solve scene by every formulation and return the outcomes, the energy solver's first."""
    return [solve_hard_scene_by_formulation(hard_scene, name) for name in formulations()]


def solve_all_hard_scenes(progress: Callable[[int, int, str], None]) -> list[FormulationOutcome]:
    """Solve every hard-to-solve scene by every formulation of the equations, in two processes.

    Parameters
    ----------
    progress
        Function that is called after each scene with the number of solved scenes, the number of all, and the scene's name.

    Returns
    -------
    list of FormulationOutcome
        Outcomes in the order of `hard_scenes`.
    """
    every, found = hard_scenes(), dict[int, list[FormulationOutcome]]()
    scenes = {i: (hard_scene,) for i, hard_scene in enumerate(every)}
    for i, outcomes in solve_many(_solve_by_all_formulations, scenes, ComputingSettings(parallel_jobs=2)):
        found[i] = outcomes
        progress(len(found), len(every), every[i].name)
    return [row for i in range(len(every)) for row in found[i]]


def unexpected_outcomes(outcomes: Sequence[FormulationOutcome]) -> list[FormulationOutcome]:
    """Return the outcomes that are not as expected, without those of publications.

    Expected is convergence or, if the loads drive a rigid motion that nothing resists, the status that names this motion.
    Outcomes whose contact loads differ from the energy solver's are returned, too.
    """
    ours = [r for r in outcomes if r.formulation == ENERGY or r.formulation in BACKENDS]
    return [
        r for r in ours if (r.status != r.expected and r.is_formulation_applicable) or (r.difference_percent or 0.0) > SAME
    ]


# --- rows of the report's table


def stability_table_rows(outcomes: Sequence[FormulationOutcome]) -> list[dict[str, Cell]]:
    """Return the rows of the report's stability table: for each hard-to-solve scene the status of each formulation."""
    by_case: dict[str, dict[str, Cell]] = {}
    for row in outcomes:
        line = by_case.setdefault(row.case, {"case": row.case, "group": row.group})
        line[row.formulation] = outcome_cell_text(row)
        if row.formulation == ENERGY:
            line |= {key: getattr(row, key) for key in ("iterations", "residual", "seconds", "unknowns")}
            line["bound"] = row.round_off_bound
    return list(by_case.values())


def outcome_cell_text(outcome: FormulationOutcome) -> str:
    """Return the outcome of a formulation as text of a table cell: iterations if converged, else the solver's status."""
    if outcome.status == CONVERGED:
        apart = outcome.difference_percent
        other = f", another root ({apart:.2g} % off)" if apart is not None and apart > SAME else ""
        return f"converged, {outcome.iterations} it.{other}"
    return outcome.status.split(" (")[0]


def count_expected_outcomes(outcomes: Sequence[FormulationOutcome]) -> dict[str, tuple[int, int, int]]:
    """Count for each formulation the scenes with the expected outcome, the scenes that were tried, and all scenes.

    The outcome is as expected if the solver converged or, where the loads drive a free rigid motion, named this motion.
    """
    out = {}
    for formulation in formulations():
        attempts = [r for r in outcomes if r.formulation == formulation]
        tried = [r for r in attempts if r.is_formulation_applicable]
        out[formulation] = (sum(r.status == r.expected for r in tried), len(tried), len(attempts))
    return out


Record = dict[str, Any]

#: Possible outcomes of a random scene, the good ones first.
RIGHT, REFUSED, PROVEN, NOT_UNIQUE = "right", "refused as input", "refused, proven", "refused, contacts not unique"

#: Outcomes that are faults of the program.
WRONG, UNPROVEN, SILENT, CRASHED = "wrong", "refused, unproven", "refused without a mechanism", "traceback"

#: Outcome of a scene whose answer on the command line differs from the computed one.
MISSTATED = "misstated by the command line"

#: Good and bad outcomes.
GOOD, BAD = (RIGHT, REFUSED, PROVEN, NOT_UNIQUE), (WRONG, UNPROVEN, SILENT, CRASHED, MISSTATED)

#: Columns of the report with the numbers of scenes with each bad outcome.
BAD_COLUMNS = {
    WRONG: "wrong_results",
    UNPROVEN: "refused_unproven",
    SILENT: "refused_without_reason",
    CRASHED: "tracebacks",
    MISSTATED: "misstated_results",
}


def read_campaign_records(path: Path) -> list[Record]:
    """Read the records of test campaigns, each of many random scenes, from a JSON file.

    The list is empty if the file is missing or has other content.
    """
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return []
    good = isinstance(records, list) and all(
        isinstance(r, dict) and {"command", "scenes", "files", "bad"} <= set(r) for r in records
    )
    return records if good else []


def built_in_campaign_records() -> list[Record]:
    """Return the records of test campaigns, each of many random scenes, that are part of the package."""
    return read_campaign_records(Path(__file__).with_name("campaign.json"))


def campaign_table_rows(records: Sequence[Record]) -> list[Row]:
    """Return the rows of the report's table of test campaigns, one for each campaign of many random scenes.

    ``records``: records of the campaigns. A row has the command that ran the campaign, the
    version of rollbench, and how many scenes, damaged files and killed processes led to each outcome.
    """
    out = []
    for r in records:
        files = [row for kind, row in r["files"].items() if kind != "kill"]
        scenes, kills = r["scenes"], r["files"].get("kill", {})
        ended: Row = {
            "command": r["command"],
            "rollbench_version": r.get("version", ""),
            "solved_correctly": scenes[RIGHT],
            "refused_proven": sum(scenes[verdict] for verdict in GOOD[1:]),
            "bad_outcomes": sum(scenes.get(bad, 0) for bad in BAD),
            "damaged_files": sum(sum(row.values()) for row in files),
            "damaged_files_misread": sum(row["bad"] for row in files),
            "killed_processes": sum(kills.values()),
            "incomplete_after_kill": kills.get("bad", 0),
        }
        of_kind = {column: scenes.get(verdict, 0) for verdict, column in BAD_COLUMNS.items()}
        out.append(ended | of_kind | {"what_was_wrong": "; ".join(map(_bad_case_in_words, r["bad"]))})
    return out


def _bad_case_in_words(bad: Mapping[str, Any]) -> str:
    """Return in words what was wrong with a bad case of a campaign, and its outcome when it was judged again."""
    name = f"scene {bad['scene']}" if "scene" in bad else str(bad.get("file"))
    again = bad.get("again")
    if again is None:
        return f"{name}: {bad['words']}; not judged again"
    outcome = " (".join(filter(None, (again["verdict"], again["words"] and f"{again['words']})")))
    return f"{name}: {bad['words']}; by {again['version']} on {again['date']}: {outcome}"
