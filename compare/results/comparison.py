"""Records that `rollbench.compare_models` returns: errors of low-order models against the 3D finite-element reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rollbench.compare.measure import LoadError, error_percent
from rollbench.compare.models.comparison import ContactSolution, SceneWithReference
from rollbench.compare.models.load_cases import rating_life_over_duty_cycle
from rollbench.compare.models.model_form import ExpectedError
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.set_results import SetResult, ball_load_summary
from rollbench.compare.models.stiffness import LoadPointStiffness, place_text
from rollbench.compare.models.uncertainty import Uncertainty
from rollbench.compare.quantities import json_number, record_as_json
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version
from rollbench.compare.results.rows import nested_records, rows_with_reference
from rollbench.compare.results.solved import AxialResults
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle, LoadCaseOfDutyCycle, load_cases_by_scene_name
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record
from rollbench.reports.content import Figure, Panel, Series


@dataclass(frozen=True, eq=False, repr=False)
class ModelLoads:
    """Contact loads of a model or of a 3D run, with their errors, and the pressure and life that follow.

    The four columns of arrays are the groove flanks SL, SR, NL, NR (screw or nut, left or right).
    """

    #: Contact loads and displacements of the model, or of the run of the 3D reference.
    contact_loads: ContactSolution
    #: Errors of the contact loads against the reference; None for the reference itself.
    error: LoadError | None
    #: Pressure, static safety and life, computed from the contact loads.
    derived_results: SetResult
    #: Axial position of the screw's section on which the load acts [m]; without a force, the nut's centre.
    place: float
    #: Axial displacement of the screw's section on which the load acts, to ground, from its unloaded position [m]; nan if
    #: not known.
    displacement: float
    #: Axial force of the screw on the nut [N].
    axial_force: float
    #: Number of contacts that are loaded in the screw without geometric errors.
    nominal_contacts: int
    #: Largest error of a contact load [%] as `rollbench check` defines it (`measure.load_scale_of_check_errors`).
    gate_error: float = 0.0
    #: Errors of n balls' loads on the four flanks ``(n, 4)`` [% of the mean contact load of the reference]; None for the
    #: reference itself.
    errors: Array | None = None

    @property
    def name(self) -> str:
        """Name of the model; ``3D reference``; ``3D level 1`` for a coarser mesh; or the file of a reference."""
        return self.contact_loads.model

    @property
    def loads(self) -> Array:
        """Contact loads of n balls on the four groove flanks ``(n, 4)`` [N]."""
        return self.contact_loads.load

    @property
    def angles(self) -> Array:
        """Contact angles of n balls, from the radial plane ``(n, 4)`` [rad]; nan without contact."""
        return np.where(self.loads > 0.0, np.radians(self.contact_loads.angle), np.nan)

    @property
    def L10(self) -> float | None:
        """Life [revolutions], L10 of a nut, L10r of a bearing; None without loads, and outside the formulas' range."""
        life = self.derived_results.life_by_loads
        return None if life is None else 1e6 * life.revolutions

    @property
    def seconds(self) -> float | None:
        """Computing time of the model or of the reference [s]; None if not measured."""
        return self.contact_loads.seconds or None

    @property
    def measured(self) -> str:
        """Version of rollbench and computer with which the time was measured; empty for those in use now."""
        return self.contact_loads.measured

    @property
    @QuantityDescription(
        "measured_error_percent",
        "measured largest error of a contact load, in per cent of the reference's mean load",
        error="`uncertainty.discretisation_percent`",
    )
    def largest_error(self) -> float | None:
        """Largest absolute error of a contact load [% of the mean contact load]; None for the reference itself."""
        return None if self.error is None else self.error.max_percent

    @property
    def rms_error(self) -> float | None:
        """Root mean square error over the loaded contacts [% of the mean contact load]; None for the reference itself."""
        return None if self.error is None else self.error.rms_percent

    @property
    def ball(self) -> int:
        """Number of the ball with the largest error, from 1; 0 for the reference itself."""
        return 0 if self.error is None else self.error.ball

    @property
    def side(self) -> str:
        """Groove flank with the largest error: SL, SR, NL or NR; empty for the reference itself."""
        return "" if self.error is None else self.error.side

    def __repr__(self) -> str:
        """Return a text with the name, and for a model its largest and its root mean square error."""
        if self.error is None:
            return self.name
        return f"{self.name}: largest error {self.largest_error:.2f} % of the mean load, RMS {self.rms_error:.2f} %"

    @property
    def title(self) -> str:
        """Name of the model, or of the run of the 3D reference, in tables and sentences."""
        return model_title(self.contact_loads.model)

    @property
    def pressure(self) -> float:
        """Largest contact pressure [Pa]; zero if no contact is loaded."""
        return 0.0 if self.derived_results.worst is None else self.derived_results.worst.pressure


@result_record(eq=False, repr=False, kw_only=True)
class Comparison(TabularRecord):
    """Errors of low-order models against a reference.

    With several nuts or bearings on one shaft, `sets` has a comparison for each. With several load cases, `cases` has a
    comparison for each, which may in turn have `sets`. In both cases the fields about contacts are None or empty.

    Examples
    --------
    >>> import rollbench
    >>> comparison = rollbench.compare_models("lin-case1", ["lin"])
    >>> lin = comparison.models["lin"]
    >>> round(lin.largest_error, 1), round(lin.rms_error, 1), lin.ball, lin.side
    (6.2, 2.5, 31, 'SL')
    >>> round(comparison.uncertainty.discretisation, 2), comparison.levels
    (0.08, (1, 2, 3, 4))
    """

    scene: str
    """Name of the scene; for one of several nuts or bearings, also the name of the nut or bearing."""
    warnings: tuple[str, ...] = ()
    """Warnings, such as unknown columns of a file."""
    of: SceneWithReference | None = None
    """Nut or bearing, and its reference; None with `sets` or `cases`."""
    reference: ModelLoads | None = None
    """Contact loads of the reference."""
    models: Mapping[str, ModelLoads] = field(default_factory=dict)
    """Loads and errors of the models, and of the 3D reference on coarser meshes, by name."""
    expected_error: ExpectedError | None = quantity_or_none(
        "expected_error_percent",
        "largest error of a contact load that `model_form` estimates for the model",
        QuantityDescription(
            "expected_displacement_error_percent",
            "expected error of the displacement of the load's point, along z",
            show=lambda expected: expected and expected.displacement,
        ),
        QuantityDescription(
            "expected_rigidity_error_percent",
            "expected error of the tangent rigidity of the load's point, along z",
            show=lambda expected: expected and expected.rigidity,
        ),
        QuantityDescription(
            "expected_pressure_error_percent",
            "expected error of the largest pressure",
            show=lambda expected: expected and expected.pressure,
        ),
        show=lambda expected: expected and expected.loads,
    )
    """Error of the default model (`judged_model`) that was expected from comparisons on other scenes; None if unknown."""
    uncertainty: Uncertainty | None = quantity_or_none(
        "uncertainty_percent",
        "uncertainty of the reference's most uncertain contact load that is due to its mesh, at 95 % confidence",
        show=lambda uncertainty: uncertainty and uncertainty.discretisation,
    )
    """Uncertainty of the errors, by its causes: mesh and choices of the reference, inputs of the scene."""
    unloaded_position: float = 0.0
    """Axial displacement of the screw without external loads [m], by the default model; displacements under load are
    measured from it."""
    sets: Mapping[str, Comparison] = field(default_factory=dict)
    """Comparison of each nut or bearing on a shaft with several, by name; empty for a single nut or bearing."""
    cases: Mapping[str, Comparison] = field(default_factory=dict)
    """Comparison of each load case, by name; empty without load cases."""
    described: Described | None = None
    """The compared scene; None in the records for single load cases (`cases`) and for single nuts or bearings (`sets`)."""

    @property
    def judged_model(self) -> ModelLoads:
        """Contact loads of the model whose error the verdict states: the default model if compared, else the first one."""
        return self.models.get(DEFAULT) or next(iter(self.models.values()))

    @property
    def verdict(self) -> str:
        """Sentence on the error of the default model; one line for each nut or bearing and each load case."""
        return "\n".join(map(_verdict_sentence, self._parts().values()))

    @property
    def levels(self) -> tuple[int, ...]:
        """Mesh levels of the 3D reference; empty for a user's reference."""
        return () if self.of is None else self.of.reference.levels

    @property
    def unsettled(self) -> str:
        """Sentence on loads of the 3D reference that had not converged in its iteration on normals and gaps; else empty."""
        return "" if self.of is None else self.of.reference.unsettled

    @property
    def uncertainties(self) -> Array | None:
        """Uncertainty of each contact load of the reference, (n, 4) [N]."""
        return None if self.of is None else self.of.reference.uncertainty

    @property
    def errors(self) -> dict[str, float]:
        """Largest error of a contact load of each model [% of the mean contact load], by the model's name."""
        return {name: one.error.max_percent for name, one in self.models.items() if one.error is not None}

    @property
    def seconds(self) -> dict[str, float | None]:
        """Computing time of each model [s], by its name; None if not measured."""
        return {name: one.seconds for name, one in self.models.items()}

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each contact that the reference or a model loads; flanks SL, SR, NL, NR.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        if self.cases or self.sets:
            return [{"of": name, **row} for name, one in self._parts().items() for row in one.frame_rows()]
        if self.reference is None:
            return []
        loads = {model: one.loads for model, one in self.models.items()}
        touched = np.any([self.reference.loads > 0.0, *(x > 0.0 for x in loads.values())], axis=0)
        return [
            {
                "ball": int(i) + 1,
                "flank": SIDES[j],
                "reference_N": float(self.reference.loads[i, j]),
                "uncertainty_N": None if self.uncertainties is None else float(self.uncertainties[i, j]),
                **{f"{model}_N": float(x[i, j]) for model, x in loads.items()},
                **{
                    f"{model}_error_percent": float(one.errors[i, j])
                    for model, one in self.models.items()
                    if one.errors is not None
                },
            }
            for i, j in np.argwhere(touched)
        ]

    def figure(self) -> Figure | None:
        """Return the figure of the contact loads of models and reference, a panel for each loaded flank of each part.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = [p for name, one in self._parts().items() for p in one._panels(name)]
        return Figure("comparison", f"{self.scene}: contact loads of models and reference", panels) if panels else None

    def _panels(self, part: str) -> list[Panel]:
        """Return a panel for each loaded flank of a single nut or bearing; ``part``: its name, before the flank's."""
        if self.reference is None:
            return []
        balls, shown = list(range(1, len(self.reference.loads) + 1)), []
        for j in np.flatnonzero((self.reference.loads > 0.0).any(axis=0)):
            truth = self.reference.loads[:, j]
            half = np.zeros_like(truth) if self.uncertainties is None else self.uncertainties[:, j]
            bars = ((truth - half).tolist(), (truth + half).tolist())
            series = [
                Series(self.reference.name, balls, truth.tolist(), "markers", bold=True, error_bars=bars),
                *(
                    Series(name, balls, one.loads[:, j].tolist(), "line")
                    for name, one in self.models.items()
                    if not name.startswith("3D")
                ),
            ]
            title = ", ".join(filter(None, (part, f"flank {SIDES[j]}")))
            shown.append(Panel(title, "number_of_ball", "contact_load", series, include_zero=True, integer_x=True))
        return shown

    def to_dict(self) -> dict[str, JSON]:
        """Return the models' errors, and the results of models and reference, as a dictionary of JSON values.

        Returns
        -------
        dict
            JSON values by key.
        """
        cases = load_cases_by_scene_name([] if self.described is None else [self.described])
        results = [one.part_json(cases) | {"models": _models_json(one)} for one in self._parts().values()]
        if not isinstance(self.described, DutyCycle):
            return add_schema_version({"scene": self.scene, "sets": results} if self.sets else results[0])
        summaries = [*self.cycle_summaries()]
        summary = summaries[0] if len(summaries) == 1 else {row["set"]: row for row in summaries}
        return add_schema_version({"scene": self.scene, "summary": summary, "cases": results})

    def part_json(self, cases: Mapping[str, LoadCaseOfDutyCycle]) -> dict[str, Any]:
        """Return the comparison of a single nut or bearing as JSON: verdict, errors, uncertainty and all results.

        Parameters
        ----------
        cases
            Load cases by the names of their scenes.

        Returns
        -------
        dict
            Values by their JSON keys.
        """
        assert self.of is not None
        assert self.reference is not None
        error, reference = self.judged_model.error, self.of.reference
        return {
            "scene": reference.scene,
            "verdict": self.verdict,
            "levels": list(reference.levels),
            "reference_status": reference.unsettled or "converged",
            "uncertainty": record_as_json(self.uncertainty),
            "model": self.judged_model.name,
            **record_as_json(self),
            "measured_error_percent": None if error is None else error.max_percent,
            "answers": {b.name: loads_and_rigidities_json(b) for b in (self.reference, *self.models.values())},
            **self.identifying_values(cases),
        }

    def identifying_values(self, cases: Mapping[str, LoadCaseOfDutyCycle]) -> dict[str, Any]:
        """Return the JSON values that identify one of several nuts or bearings, or of load cases; else empty.

        Parameters
        ----------
        cases
            Load cases by the names of their scenes.

        Returns
        -------
        dict
            Values by their JSON keys.
        """
        assert self.of is not None
        name = self.of.described_scene.name
        keys = {} if self.of.assembly is None else {"scene": name, "set": self.of.set_name}
        return keys | (cases[name].identifying_values if name in cases else {})

    def cycle_summaries(self) -> Iterator[dict[str, Any]]:
        """Yield for each nut or ball bearing the JSON summary of load errors and lives over all load cases."""
        assert isinstance(self.described, DutyCycle)
        for name, parts in self.described.sets.items():
            if isinstance(parts, Scene):
                by_case = {case: one.sets.get(name, one) for case, one in self.cases.items()}
                yield _cycle_summary_of_set(self.described, name, by_case)

    def _parts(self) -> dict[str, Comparison]:
        """Return the comparison of each nut or bearing, by load case and set; of a single one under an empty name."""
        return {
            ", ".join(filter(None, (name, of))): inner
            for name, one in {**self.cases, **self.sets}.items()
            for of, inner in one._parts().items()
        } or {"": self}

    @property
    def headings(self) -> Sequence[str]:
        """Headings of the columns of `table`."""
        first = next(iter(self._parts().values()))
        assert first.reference is not None
        return ("quantity", first.judged_model.title, first.reference.name, "unit", "difference", "expected")

    def table(self) -> Sequence[Sequence[str]]:
        """Return the rows of the table that ``rollbench compare`` prints: the default model beside the reference.

        Returns
        -------
        Sequence[Sequence[str]]
            The texts of each row, one for each of `headings`. Rows of several load cases, nuts or bearings follow one
            another.
        """
        rows, parts = [], self._parts().values()
        for one in parts:
            assert one.of is not None
            assert one.reference is not None
            model, reference = records_of_loads(one.judged_model), records_of_loads(one.reference)
            for name, *row in rows_with_reference(model, reference, one.expected_error):
                rows.append((", ".join(filter(None, (one.of.reference.scene * (len(parts) > 1), name))), *row))
        return rows

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: each warning, then the sentences on the error of the default model (`verdict`)."""
        return (*(f"WARNING: {words}" for words in self.warnings), *self.verdict.splitlines())

    def __repr__(self) -> str:
        """Return the scene's name, then a line for each model (with several load cases, nuts or bearings: for each)."""
        if self.cases or self.sets:
            return "\n".join([self.scene, *self.verdict.splitlines()])
        return "\n".join([f"{self.scene}: {self.verdict}", *map(repr, self.models.values())])


def _models_json(comparison: Comparison) -> dict[str, Any]:
    """Return errors, largest load and pressure, and displacement of each compared model as JSON, by the model's name."""
    return {
        b.name: {
            "largest_error_percent": b.largest_error,
            "rms_error_percent": b.rms_error,
            "largest_load_N": float(b.loads.max(initial=0.0)),
            "pressure_MPa": 1e-6 * b.pressure,
            "displacement_um": json_number(1e6 * b.displacement),
        }
        for b in comparison.models.values()
    }


#: Keys of the results of a nut or bearing that follow from its contact loads alone.
OF_LOADS = (
    "worst_contact",
    "static_safety",
    "truncation",
    "life",
    "ratings",
    "rating_refused",
    "modified_life",
    "reference_life",
    "life_words",
)


def records_of_loads(one: ModelLoads) -> dict[str, Any]:
    """Return the records of contact loads, rigidity, pressure and life of a model or of the 3D reference by their keys.

    ``one``: the contact loads, from which the other values follow.
    """
    force, moved = one.axial_force, one.displacement
    secant = force / moved if moved * force > 0.0 else None
    return {
        "loads": ball_load_summary(one.contact_loads.load, one.nominal_contacts),
        "axial": AxialResults(force),
        "load_point": LoadPointStiffness(place_text(one.place), "z", force, moved, secant, None),
        **{key: record for key, record in nested_records(one.derived_results).items() if key in OF_LOADS},
    }


def loads_and_rigidities_json(one: ModelLoads) -> dict[str, Any]:
    """Return contact loads, rigidity, pressure and life of a model or of the 3D reference as JSON.

    ``one``: the contact loads, from which the other values follow. Forces are in N, displacements in um,
    rigidities in N/um.
    """
    data = {key: record_as_json(record) for key, record in records_of_loads(one).items()}
    del data["load_point"]["tangent_N_per_um"]
    ratings = record_as_json(one.derived_results)
    return data | {key: ratings[key] for key in OF_LOADS}


def reference_uncertainty_text(reference: Reference, total: Uncertainty) -> str:
    """Return a phrase on the numerical uncertainty and mesh levels of the reference, and on the input uncertainty.

    The error of a model is judged by the numerical uncertainty: model and reference have the same inputs. ``total``:
    uncertainty of the comparison. For a reference from a user's file, the text is what the file states.
    """
    if reference.stated:
        return total.stated
    levels = ", ".join(str(run.level) for run in reference.runs)
    rest = f"; {reference.unsettled}, which is included" if reference.unsettled else ""
    of = f"3D reference on mesh level{'s' * (len(reference.runs) > 1)} {levels}{rest}"
    inputs = "" if total.inputs is None else f"; input uncertainty (tolerances) {total.inputs:.2f} %"
    return f"numerical uncertainty (mesh) {total.discretisation:.2f} % of the mean load ({of}){inputs}"


def _verdict_sentence(compared: Comparison) -> str:
    """Return one sentence on a comparison: measured and expected error of one model, and uncertainty of the reference.

    The model is the default model or, if that was not compared, the first one.
    """
    assert compared.of is not None
    assert compared.uncertainty is not None
    model, expected, e = compared.judged_model, compared.expected_error, compared.judged_model.error
    phrases = []
    if e is not None:
        where = f" (ball {e.ball} {e.side})" if e.ball else ""
        phrases.append(
            f"error of {model.title}: {e.max_percent:.2f} % of the mean load on the worst contact{where}, "
            f"{e.rms_percent:.2f} % RMS, {model.gate_error:.2f} % as judged by rollbench check"
        )
    if expected is not None:
        percent = "not covered by earlier comparisons" if expected.loads is None else f"{expected.loads:.2f} %"
        phrases.append(f"expected error: {percent}")
    return "; ".join(filter(None, [*phrases, reference_uncertainty_text(compared.of.reference, compared.uncertainty)]))


@result_record
class CycleSummary:
    """Largest error of a model's contact loads, and life, over all load cases of a duty cycle, for one nut or bearing."""

    model: str = quantity_field("model")
    """Name of the model."""
    error: float | None = quantity_field(
        "largest_error_percent",
        "largest measured error of a contact load in any case, in per cent of the mean load of its case",
    )
    case: str | None = quantity_field("largest_error_case", "load case with the largest error")
    lives: dict[str, float | None] = quantity_field(
        "life_million_revolutions",
        "life over the duty cycle by the contact loads of a model, or of the reference",
        parts=".*",
    )
    life_error: float | None = quantity_field(
        "life_error_percent", "error of the model's life against the life from the reference's loads"
    )


def _cycle_summary_of_set(cycle: DutyCycle, name: str, by_case: Mapping[str, Comparison]) -> dict[str, Any]:
    """Return a JSON summary of load errors and lives over all load cases, for the nut or bearing called ``name``.

    The load error stated is the one of the default model or, if that model was not compared, of the first model; the lives
    [10^6 revolutions] are those of all models and of the 3D reference, None if a load case has no loads.

    ``by_case``: comparison of the nut or bearing in each load case, by the name of the case.
    """
    first, errors = next(iter(by_case.values())), [(one.judged_model.error, case) for case, one in by_case.items()]
    error, worst = max(((e.max_percent, case) for e, case in errors if e is not None), default=(None, None))
    lives = {}
    for label in ("3D reference", *first.models):
        of_case = [{"3D reference": one.reference, **one.models}.get(label) for one in by_case.values()]
        rated, _ = rating_life_over_duty_cycle(cycle, name, [None if b is None else b.loads for b in of_case])
        lives[label] = None if rated is None else json_number(rated.revolutions)
    predicted, reference = lives[first.judged_model.name], lives["3D reference"]
    off = None if predicted is None or reference is None else float(error_percent(predicted, reference))
    summary = CycleSummary(first.judged_model.name, error, worst, lives, off)
    return {"scene": cycle.name, **({"set": name} if name else {}), **record_as_json(summary)}
