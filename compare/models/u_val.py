"""Validation uncertainty of the comparison with the 3D reference, per scene and quantity, as ASME V&V 20 has it.

The comparison error is E = model - reference. What E does not owe to the model is told apart by

    u_val = sqrt(u_grid^2 + u_model^2 + u_input^2),

u_grid: grid convergence of the reference; u_model: idealisations and unprinted dimensions of the reference, each varied
alone (`compare.models.modelling`); u_input: tolerances of what goes into both, each varied alone. |E| <= u_val says
that the model's own error is not told from that; else the model's error lies within E +- u_val. Per cent are of the
reference's value, those of contact loads of the mean load. u_input is computed by the source's model (lin), whose
sensitivities are cheap. Model and reference are given the same inputs, so that it cancels in E here: it is what E would
be uncertain by if one of the two were a measured screw, and the share of values within the reference's own part,
sqrt(u_grid^2 + u_model^2), stands beside. Where choices of the reference were not varied on a scene, those of the
varied scene whose effect is largest stand in, but not for a scene beyond what was compared, of which they say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.applicability import outside
from rollbench.compare.models.comparison import Loads, from_result, from_run
from rollbench.compare.models.modelling import SPOKEN_FOR, VARIED, base_run
from rollbench.compare.models.study import Study
from rollbench.compare.reference.convergence import observe
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.reference.store import Run, load
from rollbench.compare.reference.variants import VARIANTS
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Material, Scene

Take = Callable[[Scene, Loads], Array]

#: Model whose sensitivities to the inputs are taken.
SENSITIVE = "lin"
#: Name of the quantity that is judged contact by contact.
CONTACTS = "contact loads"


@dataclass(frozen=True)
class Quantity:
    """What is compared: name, unit, its values (any shape) of an answer; whether per cent are of the mean of the loaded
    contacts in place of the value itself; whether it is the load of the most loaded contact."""

    name: str
    unit: str
    take: Take
    of_mean: bool = False
    of_largest: bool = False


def _axial(scene: Scene, answer: Loads) -> Array:
    """Axial displacement [um] of the screw at the nut's centre."""
    return np.array([1e6 * float(np.interp(scene.nut.position, answer.stations, answer.line[:, 2]))])


def _angle(scene: Scene, answer: Loads) -> Array:  # noqa: ARG001 - every quantity takes the scene
    """Contact angle [deg] of the most loaded contact."""
    return np.array([float(answer.angle.ravel()[int(answer.load.argmax())])])


QUANTITIES = (
    Quantity(CONTACTS, "N", lambda scene, answer: answer.load, of_mean=True),  # noqa: ARG005
    Quantity("largest load", "N", lambda scene, answer: np.array([answer.load.max()]), of_largest=True),  # noqa: ARG005
    Quantity("axial displacement", "um", _axial),
    Quantity("contact angle of the most loaded contact", "deg", _angle),
)


@dataclass(frozen=True)
class Input:
    """A tolerance of what a drawing or a catalogue gives: words, and the scene changed by it (None where it has none)."""

    name: str
    change: Callable[[Scene], Scene | None]


def _conforming(scene: Scene) -> Scene:
    wider = 0.005 * 2.0 * scene.balls.radius
    screw = replace(scene.screw, groove_radius=scene.screw.groove_radius + wider)
    return replace(scene, screw=screw, nut=replace(scene.nut, groove_radius=scene.nut.groove_radius + wider))


def _turned(scene: Scene) -> Scene:
    return replace(scene, track=replace(scene.track, contact_angle=scene.track.contact_angle + float(np.radians(1.0))))


def _stiffer(scene: Scene) -> Scene:
    def stiffened(material: Material) -> Material:
        return replace(material, youngs_modulus=1.01 * material.youngs_modulus)

    screw = replace(scene.screw, material=stiffened(scene.screw.material))
    nut = replace(scene.nut, material=stiffened(scene.nut.material))
    return replace(scene, screw=screw, nut=nut, balls=replace(scene.balls, material=stiffened(scene.balls.material)))


def _larger(scene: Scene) -> Scene | None:
    balls = scene.errors.balls
    if balls.oversize == 0.0:
        return None
    return replace(scene, errors=replace(scene.errors, balls=replace(balls, oversize=balls.oversize + 0.25e-6)))


#: Assumed tolerances: what makers state of such parts or do not print at all; no source of a scene gives them.
INPUTS = (
    Input("conformity of both grooves 0.005", _conforming),
    Input("contact angle 1 deg", _turned),
    Input("Young's modulus 1 %", _stiffer),
    Input("oversize of the ball radius 0.25 um, where there is one", _larger),
)


@dataclass(frozen=True)
class Uncertainty:
    """Of a quantity of a scene, each of the shape of its values, in per cent: of the grid, of the reference's choices, of
    the inputs; ``varied``: the scene on which the choices were varied; grid is nan with one level, model where no varied
    scene speaks for this one."""

    grid: Array
    model: Array
    inputs: Array
    varied: str

    @property
    def of_reference(self) -> Array:
        """The reference's own: grid and choices."""
        return np.asarray(np.hypot(self.grid, self.model))

    @property
    def combined(self) -> Array:
        """u_val: root of the sum of squares; nan where a part is."""
        return np.asarray(np.sqrt(self.grid**2 + self.model**2 + self.inputs**2))


def percent(quantity: Quantity, value: Array, base: Array, mean: float) -> Array:
    """Difference in per cent of what the quantity is given in; mean: contact load [N] of the reference."""
    scale = mean if quantity.of_mean else None
    return np.asarray(error_percent(value, base, scale))


def grid_uncertainty(scene: Scene, reference: Reference, quantity: Quantity) -> Array:
    """Of the finest run, in per cent; nan with one level, but for loads, of which there is experience."""
    base = quantity.take(scene, from_run(reference.best, ""))
    if quantity.of_mean:
        return percent(quantity, reference.uncertainty, np.zeros_like(base), reference.mean)
    if quantity.of_largest:
        bar = reference.uncertainty.ravel()[int(reference.load.argmax())]
        return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))
    if len(reference.runs) < 2:
        return np.full(base.shape, np.nan)
    values = [float(quantity.take(scene, from_run(run, ""))[0]) for run in reference.runs]
    bar = observe(values, reference.sizes).uncertainty or 0.0
    return np.asarray(error_percent(np.full(base.shape, bar), np.zeros(base.shape), base))


def variants_of(study: Study, name: str) -> tuple[tuple[str, Loads, Loads], ...]:
    """Choice, answer with it changed and answer without, of every modelling choice that a store holds varied on a scene."""
    scene, out = study.scene(name), []
    bases: dict[int, Run | None] = {}
    for key, variant in VARIANTS.items():
        run = load(scene, variant.level, key, study.stores) if variant.kind == "modelling" else None
        if run is None or run.status != "converged":
            continue
        if variant.level not in bases:
            bases[variant.level] = base_run(scene, variant.level, study.stores)
        base = bases[variant.level]
        if base is not None:
            out.append((variant.choice, from_run(run, key), from_run(base, "")))
    return tuple(out)


def choice_uncertainty(study: Study, name: str, quantity: Quantity) -> Array | None:
    """Root of squares over the modelling choices that were varied on a scene, the largest of the variants of one choice;
    None where none was."""
    scene, worst = study.scene(name), dict[str, Array]()
    contacts = nominal_contacts(scene)
    for choice, changed, base in study.once(variants_of, name):
        value, unchanged = (quantity.take(scene, answer) for answer in (changed, base))
        change = np.abs(percent(quantity, value, unchanged, mean_load(base.load, contacts)))
        worst[choice] = np.maximum(worst.get(choice, np.zeros_like(change)), change)
    return np.asarray(np.sqrt(sum(x**2 for x in worst.values()))) if worst else None


def input_parts(study: Study, scene: Scene, quantity: Quantity) -> dict[str, Array]:
    """Change in per cent by every tolerance of the inputs that a scene has, by the sensitivities of a cheap model."""
    base = study.solve(scene, SENSITIVE)
    unchanged, out = quantity.take(scene, from_result(base)), {}
    mean = mean_load(base.load, nominal_contacts(scene))
    for tolerance in INPUTS:
        changed = tolerance.change(scene)
        if changed is not None:
            value = quantity.take(changed, from_result(study.solve(changed, SENSITIVE)))
            out[tolerance.name] = percent(quantity, value, unchanged, mean)
    return out


def input_uncertainty(study: Study, scene: Scene, quantity: Quantity) -> Array:
    """Root of squares over the tolerances of the inputs."""
    return np.asarray(np.sqrt(sum(change**2 for change in input_parts(study, scene, quantity).values())))


def uncertainty(study: Study, name: str, quantity: Quantity) -> Uncertainty | None:
    """The parts of u_val of a scene's quantity; None without a stored reference."""
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
    return Uncertainty(grid, model, input_uncertainty(study, scene, quantity), varied)


def choices_of(study: Study, quantity: Quantity) -> dict[str, Array]:
    """`choice_uncertainty` of every varied scene that a store holds."""
    changes = {name: choice_uncertainty(study, name, quantity) for name in VARIED}
    return {name: u for name, u in changes.items() if u is not None}


@dataclass(frozen=True)
class Validated:
    """A model on a quantity of a scene: error, parts of u_val and itself [%], of contact loads at the worst contact; the
    shares of values that lie within u_val and within the reference's own part of it; ratio: model over reference of every
    loaded contact above a tenth of the mean, or of the value; varied: scene that stands for the choices."""

    scene: str
    model: str
    quantity: str
    error: float
    grid: float
    choices: float
    inputs: float
    combined: float
    within: float
    within_own: float
    ratio: tuple[float, ...]
    varied: str

    @property
    def bar(self) -> str:
        """u_val in words, or why it is not known."""
        if np.isfinite(self.combined):
            return f"u_val {self.combined:.2f} %"
        why = "modelling choices were varied on no scene like it" if np.isfinite(self.grid) else "one mesh level"
        return f"u_val not known ({why})"


def validated(study: Study, name: str, model: str, quantity: Quantity, answer: Loads) -> Validated | None:
    """A model's answer on a quantity of a scene; None without a stored reference."""
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
    off, grid, choices, inputs, whole = (
        float(x.ravel()[worst]) for x in (error, parts.grid, parts.model, parts.inputs, parts.combined)
    )
    within, within_own = (float((np.abs(error) <= u)[judged].mean()) for u in (parts.combined, parts.of_reference))
    ratio = tuple(float(x) for x in (value[big] / reference[big]).ravel())
    return Validated(name, model, quantity.name, off, grid, choices, inputs, whole, within, within_own, ratio, parts.varied)


@dataclass(frozen=True)
class Scatter:
    """Bias and scatter of a model on a quantity over all scenes: number of scenes and of values, relative deviation
    from the reference as a geometric mean [%], relative standard deviation of the model [%] with the grid's uncertainty
    taken out, and shares of values within u_val and within the reference's own part of it."""

    model: str
    quantity: str
    scenes: int
    values: int
    bias: float
    scatter: float
    within: float
    within_own: float


def scatter(rows: Sequence[Validated]) -> list[Scatter]:
    """Bias and scatter by model and quantity.

    As fire-model validation does (NUREG-1824, supplement 1): delta = exp(mean ln(M/E)), sigma_M^2 = var(ln(M/E)) -
    sigma_E^2, the latter u_grid / 2 (a bound of 95 % taken as two standard deviations), and no less than zero. Inputs and
    choices are the same for model and reference and scatter neither.
    """
    out = []
    for model, quantity in dict.fromkeys((r.model, r.quantity) for r in rows):
        group = [r for r in rows if (r.model, r.quantity) == (model, quantity)]
        logs = np.log(np.concatenate([r.ratio for r in group]))
        known = [r.grid for r in group if np.isfinite(r.grid)]
        spread = float(np.sqrt(np.mean(np.square(known)))) / 200.0 if known else 0.0
        variance = float(logs.var(ddof=1)) if logs.size > 1 else 0.0
        bias = float(error_percent(np.exp(logs.mean()), 1.0))
        left = float(error_percent(np.sqrt(max(variance - spread**2, 0.0)), 0.0, 1.0))
        shares = [float(np.mean(x)) for x in ([r.within for r in group], [r.within_own for r in group])]
        out.append(Scatter(model, quantity, len(group), logs.size, bias, left, *shares))
    return out


def bound_shares(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, int]]:
    """By model: measured errors within what was expected of them, and of how many any was (`ladder.left_out_one`)."""
    out: dict[str, tuple[int, int]] = {}
    for row in rows:
        if row["expected"] is None:
            continue
        within, total = out.get(str(row["model"]), (0, 0))
        good = float(row["measured"]) <= float(row["expected"])
        out[str(row["model"])] = (within + good, total + 1)
    return out
