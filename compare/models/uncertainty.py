"""Uncertainty of a comparison with the 3D reference, in parts that add by squares.

By ASME V&V 20, the comparison error of a quantity is E = model - reference. The error of the model is distinguished from
the errors of reference and inputs by the validation uncertainty

    u_val = sqrt(u_grid^2 + u_model^2 + u_input^2),

u_grid: grid convergence of the reference (`compare.reference.grid_parts`); u_model: idealisations and unprinted dimensions
of the reference, each varied separately (`compare.models.modelling`); u_input: tolerances of the inputs of both, each
varied separately. If |E| <= u_val, the error of the model cannot be distinguished from it; else it lies within E +- u_val.
Percentages are of the reference's value, those of contact loads of the mean load. u_input is computed by the source's model
(lin), whose sensitivities are cheap. Model and reference get the same inputs, so u_input cancels in E here: it is the
uncertainty of E if one of the two were a measured screw. The share of values within the reference's part, sqrt(u_grid^2 +
u_model^2), is therefore given too. If choices were not varied on a scene, those of the varied scene with the largest effect
are taken, unless the scene lies beyond what was compared. u_val is not known if a part is not.

The largest contact load of a scene (`total`) has a fourth part, the second order of displacements, which the reference
neglects: CalculiX finds contacts of the scene two-balls weaker by large displacements in proportion to their larger
semi-axis a over the ball radius r, dF / F = -`SECOND_ORDER` a / r, within 15 %. Here an unknown part counts as zero, and
the text says so. Contacts of a screw whose sum of loads is not fixed by equilibrium share a further part: independent 3D
programs find that sum larger by `SHARED`, with one sign, while finer meshes of the reference move it by less and the other
way.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.models.answers import load_answers
from rollbench.compare.models.applicability import outside
from rollbench.compare.models.comparison import Loads, from_result, from_run
from rollbench.compare.models.modelling import SPOKEN_FOR, VARIED, Modelling, base_run
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.study import Study
from rollbench.compare.reference.convergence import grid_convergence
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.reference.grid_parts import both_flanks
from rollbench.compare.reference.store import Run, load_run, shipped_store
from rollbench.compare.reference.variants import VARIANTS
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES, Material, Scene
from rollbench.meshes.quantity import Stated, quantity, record

Take = Callable[[Scene, Loads], Array]

#: Names of parts.
GRID, CHOICES, INPUT, SECOND = "discretisation", "modelling choices", "inputs", "large displacements"
#: Record of the modelling choices, next to the stored runs.
FILE = "choices.json"
#: Relative loss of load by large displacements, over a / r [1] (tests/unit/models/test_uncertainty.py).
SECOND_ORDER = 0.030
#: Excess of the sum of loads in independent 3D programs over the reference, preloaded scenes, smallest and largest [%].
SHARED = (0.12, 0.19)
#: Model that gives the sensitivities to the inputs.
SENSITIVE = "lin"
#: Name of the quantity that is judged contact by contact.
CONTACTS = "contact loads"


@dataclass(frozen=True)
class Quantity:
    """Quantity of which model and reference are compared, with the function that computes it."""

    #: Name of the quantity.
    name: str
    #: Unit of its values.
    unit: str
    #: Function that takes its values (any shape) from an answer.
    take: Take
    #: Whether percentages are of the mean of the loaded contacts instead of the value.
    of_mean: bool = False
    #: Whether it is the load of the most loaded contact.
    of_largest: bool = False


def _axial_displacement(scene: Scene, answer: Loads) -> Array:
    """Return the axial displacement of the screw at the nut's centre, (1,) [um]."""
    return np.array([1e6 * float(np.interp(scene.nut.position, answer.stations, answer.line[:, 2]))])


def _angle_at_most_loaded(scene: Scene, answer: Loads) -> Array:  # noqa: ARG001 - every quantity takes the scene
    """Return the contact angle of the most loaded contact, (1,) [deg]."""
    return np.array([float(answer.angle.ravel()[int(answer.load.argmax())])])


QUANTITIES = (
    Quantity(CONTACTS, "N", lambda scene, answer: answer.load, of_mean=True),  # noqa: ARG005
    Quantity("largest load", "N", lambda scene, answer: np.array([answer.load.max()]), of_largest=True),  # noqa: ARG005
    Quantity("axial displacement", "um", _axial_displacement),
    Quantity("contact angle of the most loaded contact", "deg", _angle_at_most_loaded),
)


@dataclass(frozen=True)
class InputTolerance:
    """Tolerance of an input value, as a change of the scene."""

    #: Description, with the size of the tolerance.
    name: str
    #: Function that changes a scene by it; None if the scene has no such value.
    change: Callable[[Scene], Scene | None]


def _with_wider_grooves(scene: Scene) -> Scene:
    """Return the scene with both groove radii larger by 0.005 ball diameters."""
    wider = 0.005 * 2.0 * scene.balls.radius
    screw = replace(scene.screw, groove_radius=scene.screw.groove_radius + wider)
    return replace(scene, screw=screw, nut=replace(scene.nut, groove_radius=scene.nut.groove_radius + wider))


def _with_larger_contact_angle(scene: Scene) -> Scene:
    """Return the scene with a contact angle larger by 1 deg."""
    return replace(scene, track=replace(scene.track, contact_angle=scene.track.contact_angle + float(np.radians(1.0))))


def _with_stiffer_material(scene: Scene) -> Scene:
    """Return the scene with all Young's moduli larger by 1 %."""

    def stiffened(material: Material) -> Material:
        return replace(material, youngs_modulus=1.01 * material.youngs_modulus)

    screw = replace(scene.screw, material=stiffened(scene.screw.material))
    nut = replace(scene.nut, material=stiffened(scene.nut.material))
    return replace(scene, screw=screw, nut=nut, balls=replace(scene.balls, material=stiffened(scene.balls.material)))


def _with_larger_oversize(scene: Scene) -> Scene | None:
    """Return the scene with an oversize of the ball radii larger by 0.25 um; None without oversize."""
    balls = scene.errors.balls
    if balls.oversize == 0.0:
        return None
    return replace(scene, errors=replace(scene.errors, balls=replace(balls, oversize=balls.oversize + 0.25e-6)))


#: Assumed tolerances: makers state them for such parts or do not print them; no source of a scene gives them.
INPUTS = (
    InputTolerance("conformity of both grooves 0.005", _with_wider_grooves),
    InputTolerance("contact angle 1 deg", _with_larger_contact_angle),
    InputTolerance("Young's modulus 1 %", _with_stiffer_material),
    InputTolerance("oversize of the ball radius 0.25 um, where there is one", _with_larger_oversize),
)


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of a quantity, in parts."""

    #: Parts by name in per cent, each a number or of the shape of the values; nan: not known.
    parts: Mapping[str, Array | float]
    #: Scene on which the modelling choices were varied.
    varied: str = ""

    def combined(self, *names: str, unknown: float = np.nan) -> Array:
        """Return the root of the sum of squares of the parts.

        Parameters
        ----------
        *names
            Parts to combine; all unless given.
        unknown
            Value of a part that is not known.

        Returns
        -------
        Array
            The sum, in per cent.
        """
        parts = (np.asarray(self.parts[name]) for name in names or self.parts)
        return np.asarray(np.sqrt(sum(np.where(np.isnan(part), unknown, part) ** 2 for part in parts)))


def percent(quantity: Quantity, value: Array, base: Array, mean: float) -> Array:
    """Return value - base in per cent of the base, or of the mean load [N] for a quantity ``of_mean``."""
    scale = mean if quantity.of_mean else None
    return np.asarray(error_percent(value, base, scale))


def grid_uncertainty(scene: Scene, reference: Reference, quantity: Quantity) -> Array:
    """Return a quantity's grid uncertainty in the finest run [%]; with one level nan, but loads by experience."""
    base = quantity.take(scene, from_run(reference.best, ""))
    if quantity.of_mean:
        return percent(quantity, reference.uncertainty, np.zeros_like(base), reference.mean)
    if quantity.of_largest:
        bar = reference.uncertainty.ravel()[int(reference.load.argmax())]
        return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))
    if len(reference.runs) < 2:
        return np.full(base.shape, np.nan)
    values = [float(quantity.take(scene, from_run(run, ""))[0]) for run in reference.runs]
    bar = grid_convergence(values, reference.sizes).uncertainty or 0.0
    return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))


def variants_of(study: Study, name: str) -> tuple[tuple[str, Loads, Loads], ...]:
    """Return each variant stored for a scene as (modelling choice, loads with the change, loads without it)."""
    scene, out = study.scene(name), []
    bases: dict[int, Run | None] = {}
    for key, variant in VARIANTS.items():
        run = load_run(scene, variant.level, key, study.stores) if variant.kind == "modelling" else None
        if run is None or run.status != "converged":
            continue
        if variant.level not in bases:
            bases[variant.level] = base_run(scene, variant.level, study.stores)
        base = bases[variant.level]
        if base is not None:
            out.append((variant.choice, from_run(run, key), from_run(base, "")))
    return tuple(out)


def choice_uncertainty(study: Study, name: str, quantity: Quantity) -> Array | None:
    """Return the root sum of squares over a scene's modelling choices [%], each by its largest variant."""
    scene, worst = study.scene(name), dict[str, Array]()
    contacts = nominal_contacts(scene)
    for choice, changed, base in study.once(variants_of, name):
        value, unchanged = (quantity.take(scene, answer) for answer in (changed, base))
        change = np.abs(percent(quantity, value, unchanged, mean_load(base.load, contacts)))
        worst[choice] = np.maximum(worst.get(choice, np.zeros_like(change)), change)
    return Uncertainty(worst).combined() if worst else None


def input_parts(study: Study, scene: Scene, quantity: Quantity) -> dict[str, Array]:
    """Return the change of a quantity [%] by each input tolerance of a scene, computed by the model lin."""
    base = study.solve(scene, SENSITIVE)
    unchanged, out = quantity.take(scene, from_result(base)), {}
    mean = mean_load(base.load, nominal_contacts(scene))
    for tolerance in INPUTS:
        changed = tolerance.change(scene)
        if changed is not None:
            value = quantity.take(changed, from_result(study.solve(changed, SENSITIVE)))
            out[tolerance.name] = percent(quantity, value, unchanged, mean)
    return out


def input_uncertainty(study: Study, scene: Scene, quantity: Quantity) -> tuple[Array, str]:
    """Return the root sum of squares over all input tolerances [%], and the name of the most effective tolerance."""
    parts = input_parts(study, scene, quantity)
    return Uncertainty(parts).combined(), max(parts, key=lambda name: float(np.abs(parts[name]).max()))


def uncertainty(study: Study, name: str, quantity: Quantity) -> Uncertainty | None:
    """Compute the parts of the validation uncertainty u_val of one quantity of a scene; None without a reference."""
    reference = study.reference(name)
    if reference is None:
        return None
    scene = study.scene(name)
    grid = grid_uncertainty(scene, reference, quantity)
    choices = {} if outside(scene) else study.once(choices_of, quantity)
    speaks = SPOKEN_FOR.get(name, "")
    if speaks in choices and choices[speaks].shape == grid.shape:
        model, varied = choices[speaks], speaks
    elif choices:
        varied = max(choices, key=lambda k: float(choices[k].max()))
        model = np.full(grid.shape, float(choices[varied].max()))
    else:
        varied, model = "", np.full(grid.shape, np.nan)
    return Uncertainty({GRID: grid, CHOICES: model, INPUT: input_uncertainty(study, scene, quantity)[0]}, varied)


def choices_of(study: Study, quantity: Quantity) -> dict[str, Array]:
    """Return, by scene on which modelling choices were varied, their joint effect on a quantity [%]."""
    changes = {name: choice_uncertainty(study, name, quantity) for name in VARIED}
    return {name: u for name, u in changes.items() if u is not None}


@dataclass(frozen=True)
class Validated:
    """Error of a model in a quantity of a scene, with the parts of u_val [%]; of contact loads, at the worst one."""

    scene: str
    model: str
    quantity: str
    #: Error of the model [%].
    error: float
    #: Grid uncertainty of the reference [%].
    grid: float
    #: Uncertainty by modelling choices of the reference [%].
    choices: float
    #: Uncertainty by tolerances of the inputs [%].
    inputs: float
    #: u_val [%].
    combined: float
    #: Share of values within u_val.
    within: float
    #: Share of values within the reference's part of u_val.
    within_own: float
    #: Model over reference, of the value or of every loaded contact above a tenth of the mean.
    ratio: tuple[float, ...]
    #: Scene on which the modelling choices were varied.
    varied: str

    @property
    def bar(self) -> str:
        """Text with u_val [%], or why it is not known."""
        if np.isfinite(self.combined):
            return f"u_val {self.combined:.2f} %"
        why = "modelling choices were varied on no scene like it" if np.isfinite(self.grid) else "one mesh level"
        return f"u_val not known ({why})"


def validated_error(study: Study, name: str, model: str, quantity: Quantity, answer: Loads) -> Validated | None:
    """Compare a model's answer in one quantity of a scene with the reference; None without a stored reference."""
    ref, parts = study.reference(name), study.once(uncertainty, name, quantity)
    if ref is None or parts is None:
        return None
    scene = study.scene(name)
    reference = quantity.take(scene, from_run(ref.best, ""))
    value = quantity.take(scene, answer)
    error = percent(quantity, value, reference, ref.mean)
    floor = 0.1 * ref.mean if quantity.of_mean else 0.0
    # every loaded contact is judged; a value by itself is one
    judged = ((value > 0.0) | (reference > 0.0)) if quantity.of_mean else np.ones(value.shape, dtype=bool)
    big = judged & (reference > floor) & (value > 0.0) if quantity.of_mean else reference * value > 0.0
    worst = int(np.argmax(np.where(judged, np.abs(error), -1.0)))
    u_val, of_reference = parts.combined(), parts.combined(GRID, CHOICES)
    each = (parts.parts[name] for name in (GRID, CHOICES, INPUT))
    off, grid, choices, inputs, whole = (float(np.ravel(x)[worst]) for x in (error, *each, u_val))
    within, within_own = (float((np.abs(error) <= u)[judged].mean()) for u in (u_val, of_reference))
    ratio = tuple(float(x) for x in (value[big] / reference[big]).ravel())
    return Validated(name, model, quantity.name, off, grid, choices, inputs, whole, within, within_own, ratio, parts.varied)


@dataclass(frozen=True)
class Scatter:
    """Bias and scatter of a model in one quantity over all scenes."""

    model: str
    quantity: str
    #: Number of scenes.
    scenes: int
    #: Number of values.
    values: int
    #: Relative deviation from the reference, as a geometric mean [%].
    bias: float
    #: Relative standard deviation of the model without the grid uncertainty [%].
    scatter: float
    #: Share of values within u_val.
    within: float
    #: Share of values within the reference's part of u_val.
    within_own: float


def scatter(rows: Sequence[Validated]) -> list[Scatter]:
    """Compute bias and scatter by model and quantity, as in fire-model validation (NUREG-1824, supplement 1).

    Notes
    -----
    delta = exp(mean ln(M/E)), sigma_M^2 = var(ln(M/E)) - sigma_E^2, the latter u_grid / 2 (a bound of 95 % taken as two
    standard deviations), and at least zero. Inputs and choices are the same for model and reference and cause no scatter.
    """
    out = []
    for model, name in dict.fromkeys((r.model, r.quantity) for r in rows):
        group = [r for r in rows if (r.model, r.quantity) == (model, name)]
        logs = np.log(np.concatenate([r.ratio for r in group]))
        known = [r.grid for r in group if np.isfinite(r.grid)]
        spread = float(np.sqrt(np.mean(np.square(known)))) / 200.0 if known else 0.0
        variance = float(logs.var(ddof=1)) if logs.size > 1 else 0.0
        bias = float(error_percent(np.exp(logs.mean()), 1.0))
        left = float(error_percent(np.sqrt(max(variance - spread**2, 0.0)), 0.0, 1.0))
        shares = [float(np.mean(x)) for x in ([r.within for r in group], [r.within_own for r in group])]
        out.append(Scatter(model, name, len(group), logs.size, bias, left, *shares))
    return out


def bound_shares(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, int]]:
    """Count, by model, the rows of `left_out_one` with measured <= expected error, and those with an estimate."""
    out: dict[str, tuple[int, int]] = {}
    for row in rows:
        if row["expected"] is None:
            continue
        within, total = out.get(str(row["model"]), (0, 0))
        good = float(row["measured"]) <= float(row["expected"])
        out[str(row["model"])] = (within + good, total + 1)
    return out


# --- the largest contact load of a scene


@dataclass(frozen=True)
class ChoiceEffects:
    """Effects of the modelling choices that were varied on a scene."""

    #: Name of the scene.
    scene: str
    #: Largest change of a contact load by all choices together [% of the mean load].
    percent: float
    #: Choice with the largest effect.
    choice: str
    #: Effect of this choice [% of the mean load].
    alone: float


@record
class LoadUncertainty:
    """Uncertainty of the contact loads of a scene [% of the mean load], by part; None: not known."""

    #: Discretisation of the reference.
    discretisation: float
    #: Whether it is from experience with other scenes, as with a single mesh level.
    by_experience: bool = quantity("discretisation_by_experience")
    #: Modelling choices, with the dominant one and the scene on which they were varied.
    choices: ChoiceEffects | None = quantity(
        "modelling_percent",
        "what choices change that no mesh shows",
        Stated("modelling_dominated_by", show=lambda choices: choices and choices.choice),
        Stated("modelling_varied_on", show=lambda choices: choices and choices.scene),
        show=lambda choices: choices and choices.percent,
    )
    #: Tolerances of the inputs.
    inputs: float | None = quantity("input_percent", "what tolerances of the input change")
    #: Dominant input.
    input: str = quantity("input_dominated_by", show=lambda name: name or None)
    #: Second order of displacements.
    second_order: float = quantity("large_displacements_percent", "what the second order of displacements changes")
    #: Whether the sum of loads has a part that all contacts share.
    shared: bool = quantity(
        "shared_by_all_percent",
        "part that all contacts share and no mesh shows; null where it is not known",
        show=lambda shared: SHARED if shared else None,
    )
    #: Text on the uncertainty of a user's reference, shown in place of the parts; empty for a computed reference.
    stated: str = ""
    #: Part of the discretisation for the contact ``at_face``, near a free face of the nut (`compare.reference.grid_parts`).
    beside_face: float = quantity(
        "beside_free_face_percent",
        "of it, what the cells leave out of the lip's compliance at the contact `uncertainty.beside_free_face_at`; 0 where "
        "it is less than the rest",
        default=0.0,
    )
    #: Contact near a free face of the nut with the largest such part.
    at_face: str = quantity("beside_free_face_at", show=lambda contact: contact or None, default="")

    @property
    @Stated("discretisation_percent", "that of the mesh, by refinement or, with one level, by experience")
    def of_mesh(self) -> float | None:
        """Uncertainty by discretisation [%]; None for a user's reference, which states one number for everything."""
        return None if self.stated else self.discretisation

    @property
    @Stated("total_percent", "discretisation, modelling and input as independent errors")
    def percent(self) -> float:
        """Root of the sum of squares of all parts [%]; unknown parts count as zero."""
        choices = np.nan if self.choices is None else self.choices.percent
        inputs = np.nan if self.inputs is None else self.inputs
        parts = {GRID: self.discretisation, CHOICES: choices, INPUT: inputs, SECOND: self.second_order}
        return float(Uncertainty(parts).combined(unknown=0.0))

    @property
    def text(self) -> str:
        """Sentence with the combined uncertainty and its parts."""
        if self.stated:
            return self.stated
        grid = f"discretisation {self.discretisation:.2f} %{' by experience with other scenes' * self.by_experience}"
        if self.at_face:
            grid += f", of it {self.beside_face:.2f} % at {self.at_face} near the nut's free face"
        c = self.choices
        modelling = "modelling choices not known" if c is None else f"modelling choices {c.percent:.2f} %, most {c.choice}"
        inputs = (
            "inputs not known"
            if self.inputs is None
            else f"inputs {self.inputs:.2f} %, most {self.input.partition(',')[0]}"
        )
        second = f"large displacements {self.second_order:.2f} %"
        return f"uncertain by {self.percent:.2f} % in all: {grid}; {modelling}; {inputs}; {second}"

    @property
    def beside(self) -> str:
        """Sentence on the error of the sum of loads that no part contains; empty if equilibrium fixes that sum."""
        if not self.shared:
            return ""
        low, high = SHARED
        return (
            f"Beside it, for all contacts alike: independent 3D programs find sums of preloaded screws {low:g} to {high:g} "
            "% larger than the 3D reference; no mesh shows it, no bar holds it."
        )


def total(scene: Scene, reference: Reference, *, inputs: bool = True) -> LoadUncertainty:
    """Compute the uncertainty of the contact loads of a scene's reference.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    reference
        Its reference.
    inputs
        Whether the tolerances of the inputs are varied (several solutions).

    Returns
    -------
    Total
        The parts.
    """
    if reference.stated:
        return LoadUncertainty(uncertainty_percent(reference), False, None, None, "", 0.0, False, reference.stated)
    share, name = _largest_input_effect(scene) if inputs else (None, "")
    lip, at = beside_face(reference)
    return LoadUncertainty(
        uncertainty_percent(reference),
        reference.parts.by_experience,
        choices_for(replace(scene, name=reference.best.scene), read_choices(shipped_store())),
        share,
        name,
        second_order(scene, reference),
        both_flanks(reference.load),
        beside_face=lip,
        at_face=at,
    )


def beside_face(reference: Reference) -> tuple[float, str]:
    """Return the largest uncertainty of a contact due to a free face near it [% of the mean load], and the contact.

    Zero and an empty text if it is not above the rest of the uncertainty by discretisation.
    """
    share = np.zeros(1) if reference.beside_face is None else error_percent(reference.beside_face, 0.0, reference.mean)
    if share.max() <= reference.parts.bar or not reference.parts.bar:
        return 0.0, ""
    ball, side = np.unravel_index(int(share.argmax()), share.shape)
    return float(share.max()), f"ball {ball + 1} {SIDES[side]}"


def second_order(scene: Scene, reference: Reference) -> float:
    """Return the reduction of the largest contact load by large displacements [% of the mean load]."""
    worst = load_answers(scene, reference.load, np.radians(reference.best.angle)).worst
    if worst is None:
        return 0.0
    lost = SECOND_ORDER * worst.a / scene.balls.radius * worst.force
    return float(error_percent(lost, 0.0, mean_load(reference.load)))


def _largest_input_effect(scene: Scene) -> tuple[float | None, str]:
    """Return the largest joint effect of the input tolerances on a contact load [%], and the dominant input."""
    study = Study()
    if not MODELS[SENSITIVE].suits(scene) or not study.solve(scene, SENSITIVE).converged:
        return None, ""
    parts, most = input_uncertainty(study, scene, QUANTITIES[0])
    return float(parts.max()), most


def choice_effects_record(varied: Modelling) -> ChoiceEffects:
    """Return the record, for a store, of the effects of the modelling choices varied on a scene."""
    first = max(varied.choices, key=lambda name: varied.choices[name])
    return ChoiceEffects(varied.scene, varied.largest, first, varied.choices[first])


def choices_for(scene: Scene, known: Mapping[str, ChoiceEffects]) -> ChoiceEffects | None:
    """Return the choices' effects used for a scene: of a scene with its parts, else the largest; None if outside."""
    if outside(scene):
        return None
    return known.get(SPOKEN_FOR.get(scene.name, "")) or max(known.values(), key=lambda c: c.percent, default=None)


def save_choices(store: Path, known: Mapping[str, ChoiceEffects]) -> None:
    """Write the effects of modelling choices by scene to a store; OSError if the file cannot be written."""
    replace_file(store / FILE, json.dumps({name: asdict(c) for name, c in known.items()}, indent=1) + "\n")


@cache
def read_choices(store: Path) -> dict[str, ChoiceEffects]:
    """Read the effects of modelling choices by scene; OSError, ValueError or TypeError if the file cannot be used."""
    return {
        name: ChoiceEffects(**fields) for name, fields in json.loads((store / FILE).read_text(encoding="utf-8")).items()
    }
