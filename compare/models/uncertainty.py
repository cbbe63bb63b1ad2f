"""Uncertainty of a comparison with the 3D reference, as the root of the sum of squares of its parts.

By ASME V&V 20, the comparison error of a quantity is E = model - reference. The validation uncertainty

    u_val = sqrt(u_grid^2 + u_model^2 + u_input^2)

has three parts. u_grid is the grid uncertainty of the reference (`compare.reference.estimate`). u_model is the effect
of idealisations and of unprinted dimensions of the reference, each varied separately (`compare.models.modelling`). u_input
is the effect of tolerances of the inputs, each varied separately. If |E| <= u_val, the error of the model cannot be
distinguished from these uncertainties; else it lies within E +- u_val. u_val is not known if one of its parts is not.

`Uncertainty` has the three parts of one value and, for the loads of a scene's contacts, what they consist of.

Percentages refer to the value by the 3D reference, those of contact loads to the mean load. u_input is computed by the
model of Lin's thesis (lin), because this takes little time. Model and reference get the same inputs, so that u_input
cancels in E; it would count if one of the two were a measured screw. Therefore the share of values within
sqrt(u_grid^2 + u_model^2), the part of the reference, is stated too. If the modelling choices were not varied on a scene,
the largest effect on the scenes on which they were varied is used, unless the scene is outside the range of the compared
scenes.

The largest contact load of a scene (`uncertainty_of_loads`) has a fourth part, the second-order effect of displacements,
which the reference neglects. On the scene two-balls, large displacements in CalculiX reduce the contact forces F in
proportion to the larger semi-axis a of the contact over the ball radius r: dF / F = -`SECOND_ORDER` a / r, within 15 %. In
this sum, an unknown part counts as zero, and the text for the user says so.

If equilibrium does not determine the sum of the contact loads, as in a preloaded screw, all contacts share a further error.
Independent 3D programs obtain a sum that is larger by `SHARED`, always with this sign, whereas refining the mesh of the
reference changes the sum by less and in the opposite direction.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models.answers import results_of_contact_loads
from rollbench.compare.models.applicability import descriptors_outside_range
from rollbench.compare.models.comparison import ContactSolution, solution_from_result, solution_from_run
from rollbench.compare.models.modelling import SPOKEN_FOR, VARIED, ModellingUncertainty, run_without_changed_choices
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.stiffness import place_of_displacement
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.convergence import grid_convergence
from rollbench.compare.reference.estimate import Reference, has_both_flanks_loaded, largest_uncertainty_percent
from rollbench.compare.reference.levels import VARIANTS
from rollbench.compare.reference.store import Run, load_stored_run, shipped_store
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Material, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record, text_or_none

#: Function that returns the values of a quantity from a scene and the results of a model or 3D run.
Take = Callable[[Scene, ContactSolution], Array]

#: By the name of each scene on which modelling choices of the 3D reference were varied: largest change of a contact load by
#: all choices together [% of the mean load], and the choice with the largest effect.
ChoiceEffects = Mapping[str, tuple[float, str]]

#: File with the effects of the modelling choices, in a folder of 3D reference runs.
FILE = "choices.json"
#: Relative reduction of a contact load by large displacements, divided by the larger semi-axis of the contact over the ball
#: radius [1] (tests/unit/models/test_uncertainty.py).
SECOND_ORDER = 0.030
#: Smallest and largest amount [%] by which the sum of the contact loads of a preloaded scene is larger in independent 3D
#: programs than in the 3D reference.
SHARED = (0.12, 0.19)
#: Model that gives the sensitivities to the inputs.
SENSITIVE = "lin"
#: Name of the quantity that consists of the loads of all contacts.
CONTACTS = "contact loads"


@dataclass(frozen=True)
class ComparedQuantity:
    """Quantity by which a model is compared with the 3D reference, such as the axial displacement."""

    #: Name of the quantity.
    name: str
    #: Unit of the quantity's values.
    unit: str
    #: Function that returns the values of the quantity (array of any shape) from a scene and the results of a model or 3D
    #: run.
    values_of_solution: Take
    #: Whether errors of the quantity are in per cent of the mean contact load instead of the quantity itself.
    in_percent_of_mean_load: bool = False
    #: Whether the quantity is the load of the most loaded contact.
    is_largest_load: bool = False


def _axial_displacement(scene: Scene, solution: ContactSolution) -> Array:
    """Return the axial displacement of the screw's section on which the load acts, to ground, as an array (1,) [um].

    ``solution``: contact loads and displacements by a model or by the 3D reference.
    """
    return np.array([1e6 * float(np.interp(place_of_displacement(scene), solution.stations, solution.line[:, 2]))])


def _angle_of_most_loaded_contact(scene: Scene, solution: ContactSolution) -> Array:  # noqa: ARG001 - every quantity takes the scene
    """Return the contact angle of the most loaded contact as an array (1,) [deg].

    ``solution``: contact loads and angles by a model or by the 3D reference.
    """
    return np.array([float(solution.angle.ravel()[int(solution.load.argmax())])])


#: Quantities by which models are compared with the 3D reference.
QUANTITIES = (
    ComparedQuantity(CONTACTS, "N", lambda scene, answer: answer.load, in_percent_of_mean_load=True),  # noqa: ARG005
    ComparedQuantity("largest load", "N", lambda scene, answer: np.array([answer.load.max()]), is_largest_load=True),  # noqa: ARG005
    ComparedQuantity("displacement of the load's point", "um", _axial_displacement),
    ComparedQuantity("contact angle of the most loaded contact", "deg", _angle_of_most_loaded_contact),
)


def _with_wider_grooves(scene: Scene) -> Scene:
    """Return a copy of the scene with both groove radii increased by 0.005 ball diameters."""
    wider = 0.005 * 2.0 * scene.balls.radius
    screw = replace(scene.screw, groove_radius=scene.screw.groove_radius + wider)
    return replace(scene, screw=screw, nut=replace(scene.nut, groove_radius=scene.nut.groove_radius + wider))


def _with_larger_contact_angle(scene: Scene) -> Scene:
    """Return a copy of the scene with the contact angle increased by 1 deg."""
    return replace(scene, track=replace(scene.track, contact_angle=scene.track.contact_angle + float(np.radians(1.0))))


def _with_stiffer_material(scene: Scene) -> Scene:
    """Return a copy of the scene with all Young's moduli increased by 1 %."""

    def with_higher_modulus(material: Material) -> Material:
        """Return a copy of a material with Young's modulus increased by 1 %."""
        return replace(material, youngs_modulus=1.01 * material.youngs_modulus)

    screw = replace(scene.screw, material=with_higher_modulus(scene.screw.material))
    nut = replace(scene.nut, material=with_higher_modulus(scene.nut.material))
    balls = replace(scene.balls, material=with_higher_modulus(scene.balls.material))
    return replace(scene, screw=screw, nut=nut, balls=balls)


def _with_larger_oversize(scene: Scene) -> Scene | None:
    """Return a copy of the scene with the oversize of the ball radius increased by 0.25 um; None without oversize."""
    balls = scene.errors.balls
    if balls.oversize == 0.0:
        return None
    return replace(scene, errors=replace(scene.errors, balls=replace(balls, oversize=balls.oversize + 0.25e-6)))


#: Assumed tolerances of the inputs by name, each with the function that changes a scene by it (None: the scene lacks this
#: input). Some are values that makers state for such parts; no publication of a scene gives them.
INPUTS: dict[str, Callable[[Scene], Scene | None]] = {
    "conformity of both grooves 0.005": _with_wider_grooves,
    "contact angle 1 deg": _with_larger_contact_angle,
    "Young's modulus 1 %": _with_stiffer_material,
    "oversize of the ball radius 0.25 um, where there is one": _with_larger_oversize,
}


def root_sum_of_squares(parts: Iterable[Array | float]) -> Array:
    """Return the root of the sum of squares of uncertainties [%]; nan where one of them is nan, that is, not known."""
    return np.asarray(np.sqrt(sum(np.square(part) for part in parts)))


def difference_percent(quantity: ComparedQuantity, value: Array, base: Array, mean: float) -> Array:
    """Return ``value - base`` in per cent of ``base``; for contact loads, in per cent of the mean load ``mean`` [N].

    ``quantity``: quantity to which the values belong, which states whether they are contact loads.
    """
    scale = mean if quantity.in_percent_of_mean_load else None
    return np.asarray(error_percent(value, base, scale))


def grid_uncertainty(scene: Scene, reference: Reference, quantity: ComparedQuantity) -> Array:
    """Return the uncertainty [%] due to the mesh of a quantity by the finest run of the 3D reference.

    The array has the shape of the quantity. With a single mesh level it is nan, except for contact loads, whose uncertainty
    is then estimated from other scenes.
    """
    base = quantity.values_of_solution(scene, solution_from_run(reference.best, ""))
    if quantity.in_percent_of_mean_load:
        return difference_percent(quantity, reference.uncertainty, np.zeros_like(base), reference.mean)
    if quantity.is_largest_load:
        bar = reference.uncertainty.ravel()[int(reference.load.argmax())]
        return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))
    if len(reference.runs) < 2:
        return np.full(base.shape, np.nan)
    values = [float(quantity.values_of_solution(scene, solution_from_run(run, ""))[0]) for run in reference.runs]
    bar = grid_convergence(values, reference.sizes).uncertainty or 0.0
    return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))


def solutions_with_and_without_choices(
    cache: SceneResultCache, scene_name: str
) -> tuple[tuple[str, ContactSolution, ContactSolution], ...]:
    """Return the results of stored 3D runs of the scene ``scene_name`` with and without each changed modelling choice.

    Each item is a tuple: name of the choice, results with the change, results without it. Runs that did not converge are
    left out. ``cache``: cache of scenes and 3D references.
    """
    scene, out = cache.built_in_scene(scene_name), []
    bases: dict[int, Run | None] = {}
    for key, variant in VARIANTS.items():
        run = load_stored_run(scene, variant.level, key, cache.reference_folders) if variant.kind == "modelling" else None
        if run is None or run.status != "converged":
            continue
        if variant.level not in bases:
            bases[variant.level] = run_without_changed_choices(scene, variant.level, cache.reference_folders)
        base = bases[variant.level]
        if base is not None:
            out.append((variant.choice, solution_from_run(run, key), solution_from_run(base, "")))
    return tuple(out)


def combined_choice_effect(cache: SceneResultCache, scene_name: str, quantity: ComparedQuantity) -> Array | None:
    """Return the combined effect of the 3D reference's modelling choices on a quantity of the scene ``scene_name`` [%].

    The effects are combined as the root of the sum of squares over the choices; a choice with several variants counts with
    the largest change. None if no choice was varied on the scene. ``cache``: cache of scenes and 3D references.
    """
    scene, worst = cache.built_in_scene(scene_name), dict[str, Array]()
    contacts = count_nominal_contacts(scene)
    for choice, changed, base in cache.compute_once(solutions_with_and_without_choices, scene_name):
        value, unchanged = (quantity.values_of_solution(scene, answer) for answer in (changed, base))
        change = np.abs(difference_percent(quantity, value, unchanged, mean_load(base.load, contacts)))
        worst[choice] = np.maximum(worst.get(choice, np.zeros_like(change)), change)
    return root_sum_of_squares(worst.values()) if worst else None


def effects_of_input_tolerances(cache: SceneResultCache, scene: Scene, quantity: ComparedQuantity) -> dict[str, Array]:
    """Return the change of a quantity [%] due to each input tolerance of a scene, by name; computed by the model "lin".

    ``cache``: cache of scenes and results.
    """
    base = cache.solve_once(scene, SENSITIVE)
    unchanged, out = quantity.values_of_solution(scene, solution_from_result(base)), {}
    mean = mean_load(base.load, count_nominal_contacts(scene))
    for name, change in INPUTS.items():
        changed = change(scene)
        if changed is not None:
            value = quantity.values_of_solution(changed, solution_from_result(cache.solve_once(changed, SENSITIVE)))
            out[name] = difference_percent(quantity, value, unchanged, mean)
    return out


def combined_input_effect(cache: SceneResultCache, scene: Scene, quantity: ComparedQuantity) -> tuple[Array, str]:
    """Return the combined effect of all input tolerances on a quantity [%], and the name of the most effective tolerance.

    The effects are combined as the root of the sum of squares. ``cache``: cache of scenes and results.
    """
    parts = effects_of_input_tolerances(cache, scene, quantity)
    return root_sum_of_squares(parts.values()), max(parts, key=lambda name: float(np.abs(parts[name]).max()))


def validation_uncertainty(
    cache: SceneResultCache, scene_name: str, quantity: ComparedQuantity
) -> tuple[tuple[Array, Array, Array], str] | None:
    """Compute the three parts of the validation uncertainty u_val of a quantity of a scene [%]: mesh, choices, inputs.

    Each part has the shape of the quantity and is nan where it is not known. Also returned is the name of the scene on
    which the modelling choices of the 3D reference were varied (empty: none). None if no 3D reference of the scene is
    stored. ``cache``: cache of scenes and 3D references.
    """
    reference = cache.stored_reference(scene_name)
    if reference is None:
        return None
    scene = cache.built_in_scene(scene_name)
    grid = grid_uncertainty(scene, reference, quantity)
    choices = {} if descriptors_outside_range(scene) else cache.compute_once(combined_choice_effect_by_scene, quantity)
    speaks = SPOKEN_FOR.get(scene_name, "")
    if speaks in choices and choices[speaks].shape == grid.shape:
        model, varied = choices[speaks], speaks
    elif choices:
        varied = max(choices, key=lambda k: float(choices[k].max()))
        model = np.full(grid.shape, float(choices[varied].max()))
    else:
        varied, model = "", np.full(grid.shape, np.nan)
    return (grid, model, combined_input_effect(cache, scene, quantity)[0]), varied


def combined_choice_effect_by_scene(cache: SceneResultCache, quantity: ComparedQuantity) -> dict[str, Array]:
    """Return the combined effect of the 3D reference's modelling choices on a quantity [%], by the name of the scene.

    Only scenes on which choices were varied are included. ``cache``: cache of scenes and 3D references.
    """
    changes = {name: combined_choice_effect(cache, name, quantity) for name in VARIED}
    return {name: u for name, u in changes.items() if u is not None}


@result_record(kw_only=True)
class Uncertainty:
    """Uncertainty of the errors in a comparison with the reference, by its causes [%].

    Contact loads: per cent of the mean contact load. A cause whose contribution is not known is None.
    """

    discretisation: float
    """Uncertainty from the finite-element mesh of the reference (numerical uncertainty)."""
    by_experience: bool = quantity_field("discretisation_by_experience", default=False)
    """Whether the part due to the mesh is estimated from other scenes, because there is a single mesh level."""
    choices: float | None = quantity_or_none(
        "modelling_percent",
        "largest change of a contact load by modelling choices of the 3D reference, which finer meshes do not show",
    )
    """Uncertainty from modelling choices of the reference, which mesh refinement does not reveal."""
    largest_choice: str = text_or_none("modelling_dominated_by")
    """Modelling choice with the largest effect."""
    choices_varied_on: str = text_or_none("modelling_varied_on")
    """Name of the scene on which the modelling choices of the 3D reference were varied; empty: none."""
    inputs: float | None = quantity_or_none("input_percent", "largest change of a contact load by tolerances of the inputs")
    """Uncertainty from the tolerances of the scene's input values."""
    largest_input: str = text_or_none("input_dominated_by")
    """Name of the input whose tolerance has the largest effect."""
    second_order: float = quantity_field(
        "large_displacements_percent",
        "change of the largest contact load by large displacements, which the 3D reference neglects",
        default=0.0,
    )
    """Uncertainty from large displacements, which the geometrically linear reference neglects."""
    shared: bool = quantity_field(
        "shared_by_all_percent",
        "smallest and largest excess of the sum of the contact loads by independent 3D programs over that by the 3D "
        "reference, for scenes in which preload determines the sum; null for other scenes",
        show=lambda shared: SHARED if shared else None,
        default=False,
    )
    """Whether all contacts share a further error (`SHARED`), because equilibrium does not fix the sum of their loads."""
    stated: str = ""
    """What a user's reference file states about its uncertainty; empty for the 3D reference."""
    beside_face: float = quantity_field(
        "beside_free_face_percent",
        "part of the uncertainty due to the mesh that comes from a free face of the nut near the contact "
        "`uncertainty.beside_free_face_at`; 0 where it is less than the rest",
        default=0.0,
    )
    """Part of the mesh uncertainty at the contact ``at_face`` that is due to a near free face of the nut."""
    at_face: str = text_or_none("beside_free_face_at")
    """Contact (ball and flank) at which the part due to a near free face is largest; empty: there is no such part."""

    @property
    @QuantityDescription(
        "discretisation_percent",
        "part of the uncertainty due to the mesh: from refinement, or, with one mesh level, from other scenes",
    )
    def of_mesh(self) -> float | None:
        """Uncertainty due to the mesh [% of the mean load]; None for a user's reference, which only states a total."""
        return None if self.stated else self.discretisation

    @property
    @QuantityDescription(
        "total_percent",
        "total uncertainty: root of the sum of squares of the parts due to mesh, modelling choices, inputs and large "
        "displacements",
    )
    def total(self) -> float:
        """Total uncertainty: root of the sum of squares of all parts [%]; unknown parts count as zero."""
        parts = (self.discretisation, self.choices, self.inputs, self.second_order)
        return float(root_sum_of_squares(part or 0.0 for part in parts))

    @property
    def words(self) -> str:
        """Explanation of all causes of uncertainty; for a user's reference, what its file states about its uncertainty."""
        if self.stated:
            return self.stated
        grid = f"numerical (mesh) {self.discretisation:.2f} %{' estimated from other scenes' * self.by_experience}"
        if self.at_face:
            grid += f", of which {self.beside_face:.2f} % at {self.at_face} near the nut's free face"
        modelling, inputs = "modelling choices not known", "input (tolerances) not known"
        if self.choices is not None:
            modelling = f"modelling choices {self.choices:.2f} %, mainly {self.largest_choice}"
        if self.inputs is not None:
            inputs = f"input (tolerances) {self.inputs:.2f} %, mainly {self.largest_input.partition(',')[0]}"
        second = f"large displacements {self.second_order:.2f} %"
        return f"uncertainties of the contact loads: {grid}; {modelling}; {inputs}; {second}; together {self.total:.2f} %"

    @property
    def shared_error_sentence(self) -> str:
        """Sentence on an error common to all contact loads, which no part of the uncertainty includes.

        Empty if equilibrium determines the sum of the contact loads, which excludes such an error.
        """
        if not self.shared:
            return ""
        low, high = SHARED
        return (
            "Not included is an error that all contacts share: for preloaded screws, independent 3D programs obtain sums "
            f"of contact loads {low:g} to {high:g} % larger than the 3D reference; mesh refinement does not show it."
        )


@dataclass(frozen=True)
class ErrorWithUncertainty:
    """Error of a model in one quantity of a scene, with the validation uncertainty u_val of this error.

    For contact loads, error and uncertainty are those of the contact with the largest error.
    """

    #: Name of the scene.
    scene: str
    #: Name of the model.
    model: str
    #: Name of the quantity.
    quantity: str
    #: Error of the model against the 3D reference [%].
    error: float
    #: Uncertainty of this error by its causes [%]; nan: not known.
    uncertainty: Uncertainty
    #: Fraction of the quantity's values (such as the loads of all contacts) whose error is at most u_val [1].
    within: float
    #: Fraction of the quantity's values whose error is at most sqrt(u_grid^2 + u_model^2), the part of u_val due to the 3D
    #: reference [1].
    within_own: float
    #: Ratio of the value by the model to that by the 3D reference; for contact loads, of every load above a tenth of the
    #: mean load.
    ratio: tuple[float, ...]


def error_with_validation_uncertainty(
    cache: SceneResultCache, scene_name: str, model: str, quantity: ComparedQuantity, solution: ContactSolution
) -> ErrorWithUncertainty | None:
    """Return the error of a model in one quantity of a scene against the 3D reference, with its validation uncertainty.

    ``cache``: cache of scenes and 3D references; ``scene_name``: name of the scene; ``solution``: contact loads and
    displacements by the model ``model``. None without a stored 3D reference.
    """
    ref, known = cache.stored_reference(scene_name), cache.compute_once(validation_uncertainty, scene_name, quantity)
    if ref is None or known is None:
        return None
    scene = cache.built_in_scene(scene_name)
    reference = quantity.values_of_solution(scene, solution_from_run(ref.best, ""))
    value = quantity.values_of_solution(scene, solution)
    error = difference_percent(quantity, value, reference, ref.mean)
    floor = 0.1 * ref.mean if quantity.in_percent_of_mean_load else 0.0
    # every loaded contact counts; a scalar quantity counts as one value
    judged = ((value > 0.0) | (reference > 0.0)) if quantity.in_percent_of_mean_load else np.ones(value.shape, dtype=bool)
    big = judged & (reference > floor) & (value > 0.0) if quantity.in_percent_of_mean_load else reference * value > 0.0
    worst = int(np.argmax(np.where(judged, np.abs(error), -1.0)))
    parts, varied_on = known
    grid, choices, inputs = (float(np.ravel(part)[worst]) for part in parts)
    u_val = Uncertainty(discretisation=grid, choices=choices, choices_varied_on=varied_on, inputs=inputs)
    bounds = (root_sum_of_squares(parts), root_sum_of_squares(parts[:2]))
    within, within_own = (float((np.abs(error) <= bound)[judged].mean()) for bound in bounds)
    ratio = tuple(float(x) for x in (value[big] / reference[big]).ravel())
    off = float(np.ravel(error)[worst])
    return ErrorWithUncertainty(scene_name, model, quantity.name, off, u_val, within, within_own, ratio)


def count_within_expected_error(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, int]]:
    """Count for each model the scenes with a measured error up to the expected error, and all scenes with both errors.

    ``rows``: for each scene and model the keys ``model``, ``measured`` and ``expected`` [%], where the expected error is
    estimated without this scene (None: no estimate). The result has for each model
    the number of scenes within the expected error, then the number of scenes with both errors.
    """
    out: dict[str, tuple[int, int]] = {}
    for row in rows:
        if row["expected"] is None:
            continue
        within, total = out.get(str(row["model"]), (0, 0))
        good = float(row["measured"]) <= float(row["expected"])
        out[str(row["model"])] = (within + good, total + 1)
    return out


# --- the largest contact load of a scene


def uncertainty_of_loads(scene: Scene, reference: Reference, *, inputs: bool = True) -> Uncertainty:
    """Compute the uncertainty of the contact loads of a scene's 3D reference [% of the mean load].

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    reference
        Reference of the scene.
    inputs
        Whether the effect of input tolerances is included, which takes several solutions of a low-order model.

    Returns
    -------
    Uncertainty
        Parts of the uncertainty.
    """
    if reference.stated:
        return Uncertainty(discretisation=largest_uncertainty_percent(reference), stated=reference.stated)
    share, largest_input = _largest_combined_input_effect(scene) if inputs else (None, "")
    lip, at = largest_uncertainty_near_face(reference)
    stored = read_choice_effects(shipped_store())
    varied_on = scene_with_applicable_choices(replace(scene, name=reference.best.scene), stored)
    choices, largest_choice = stored.get(varied_on, (None, ""))
    return Uncertainty(
        discretisation=largest_uncertainty_percent(reference),
        by_experience=reference.parts.is_from_other_scenes,
        choices=choices,
        largest_choice=largest_choice,
        choices_varied_on=varied_on,
        inputs=share,
        largest_input=largest_input,
        second_order=effect_of_large_displacements(scene, reference),
        shared=has_both_flanks_loaded(reference.load),
        beside_face=lip,
        at_face=at,
    )


def largest_uncertainty_near_face(reference: Reference) -> tuple[float, str]:
    """Return the largest uncertainty of a contact load due to a near free face of the nut [% of the mean load].

    Also returned is the contact, as text with ball and flank. Zero and an empty text if this part of the uncertainty due to
    the mesh does not exceed the rest of it.
    """
    share = np.zeros(1) if reference.beside_face is None else error_percent(reference.beside_face, 0.0, reference.mean)
    if share.max() <= reference.parts.uncertainty or not reference.parts.uncertainty:
        return 0.0, ""
    ball, side = np.unravel_index(int(share.argmax()), share.shape)
    return float(share.max()), f"ball {ball + 1} {SIDES[side]}"


def effect_of_large_displacements(scene: Scene, reference: Reference) -> float:
    """Return by how much the largest contact load is smaller with large displacements considered [% of the mean load].

    The 3D reference neglects this second-order effect. 0 without load.
    """
    worst = results_of_contact_loads(scene, reference.load, np.radians(reference.best.angle)).worst
    if worst is None or worst.semi_axes is None:
        return 0.0
    lost = SECOND_ORDER * worst.semi_axes[0] / scene.balls.radius * worst.force
    return float(error_percent(lost, 0.0, mean_load(reference.load)))


def _largest_combined_input_effect(scene: Scene) -> tuple[float | None, str]:
    """Return the combined effect of all input tolerances on the most affected contact load [% of the mean load].

    Also returned is the name of the input with the largest effect. None and an empty text if the model "lin", which
    computes the effects, does not cover or does not solve the scene.
    """
    study = SceneResultCache()
    if not MODELS[SENSITIVE].covers_scene(scene) or not study.solve_once(scene, SENSITIVE).converged:
        return None, ""
    parts, most = combined_input_effect(study, scene, QUANTITIES[0])
    return float(parts.max()), most


def scene_with_applicable_choices(scene: Scene, stored: ChoiceEffects) -> str:
    """Return the name of the scene whose stored effects of modelling choices apply to ``scene``.

    It is a scene with the same parts; without such a scene, the one with the largest stored effect. The name is empty if no
    effect is stored, or if the scene is outside the range of the compared scenes.
    """
    speaks = SPOKEN_FOR.get(scene.name, "")
    if descriptors_outside_range(scene):
        return ""
    return speaks if speaks in stored else max(stored, key=lambda name: stored[name][0], default="")


def save_choice_effects(store: Path, found: Sequence[ModellingUncertainty]) -> None:
    """Write the effects of modelling choices on the contact loads of the scenes on which they were varied.

    ``store``: folder for the file. ``found``: effects, one record for each scene. OSError if the file cannot be written.
    """
    effects = {
        one.scene: {"percent": one.largest, "choice": max(one.choices, key=lambda name: one.choices[name])} for one in found
    }
    replace_file(store / FILE, json.dumps(effects, indent=1) + "\n")


@cache
def read_choice_effects(store: Path) -> ChoiceEffects:
    """Read the effects of the 3D reference's modelling choices, by scene, from the folder ``store`` of its runs.

    OSError, ValueError, KeyError or TypeError if the file cannot be used.
    """
    data = json.loads((store / FILE).read_text(encoding="utf-8"))
    return {name: (float(effect["percent"]), str(effect["choice"])) for name, effect in data.items()}
