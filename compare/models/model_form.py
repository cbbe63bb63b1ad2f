"""Expected error of a low-order model, estimated from its errors against the 3D reference on other scenes.

Each scene is described by dimensionless features (`SCALES`). On the compared scenes, which are included with rollbench or
generated at random, the errors of the model were measured. The logarithm of an error is fitted as a linear function of the
features, by ridge regression to avoid steep slopes with few scenes. The expected error is the fitted error times a factor.
This factor is chosen so that a share `SHARE` of the compared scenes has errors below the expected ones, where the expected
error of a scene follows from a fit without this scene.

This method is the leave-one-out jackknife. No theorem guarantees which share of new scenes lies below the expected error
(Barber, Candes, Ramdas and Tibshirani 2021: for an unstable fit it may be none), and the scenes of users are not drawn from
the distribution of the compared scenes. The share is therefore counted: `leave_one_out_errors` estimates every compared
scene from the others. In each quantity of the models lin and refined, at least nine of ten errors were below the estimate
(table ladder-estimate of the report; tests/unit/models/test_covered.py). A scene outside the range of the compared scenes
in any feature is "not covered".

`rollbench report` stores the errors on the built-in scenes in model_form.json; those on random screws are in
survey.json.

Each error is measured against one run of the 3D reference (`measure_model_error`). Displacement and rigidity are those of
the screw's cross-section on which the axial load acts. Outside the nut, a beam and a 3D shaft agree on the displacement of
a cross-section (Saint-Venant's principle). Inside the nut, the contacts deform the material locally, and the displacement
of a cross-section depends on its definition.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from rollbench.compare import files
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.applicability import descriptors_outside_range, survey_records_of_random_screws
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.user_models import NOT_COMPARED, WORDS
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record
from rollbench.meshes.solid import dimensions_of_3d_parts

if TYPE_CHECKING:
    from rollbench.compare.models.comparison import ContactSolution
    from rollbench.compare.reference.store import Run

#: File with the errors on built-in scenes, in a folder of 3D reference runs.
FILE = "model_form.json"

#: Fields of `ExpectedModelErrors` with the errors that are estimated, each separately: largest and RMS error of the contact
#: loads (in per cent of the mean load), errors of axial displacement and tangent rigidity of the cross-section on which the
#: axial load acts, error of the largest pressure.
QUANTITIES = ("percent", "rms_percent", "displacement_percent", "rigidity_percent", "pressure_percent")

#: Share of compared scenes whose measured error is below the expected one, which is estimated from all other scenes.
SHARE = 0.92

#: Least error [%] of each quantity, to which smaller errors are raised before their logarithm is taken.
LEAST = dict.fromkeys(QUANTITIES[:2], 0.05) | dict.fromkeys(QUANTITIES[2:], 0.1)

#: Weight of the ridge penalty (squared slopes per unit of each feature) relative to the squared misfit of one scene.
RIDGE = 2.0

#: Smallest number of compared scenes of one kind (screws, bearings, screws with a nut fixed at its flange) for an estimate.
FEWEST = 3

#: Distance outside the compared range of a feature, in units of `SCALES`, up to which a scene is covered.
MARGIN = 0.5

#: Definition of each feature, and the difference by which it is divided.
SCALES: dict[str, tuple[str, float]] = {
    "wall": ("wall thickness of the nut over the pitch radius", 0.1),
    "length": ("length of the nut over the pitch diameter", 0.8),
    "bore": ("bore of the screw over the pitch diameter", 0.5),
    "lead": ("lead over the pitch diameter", 0.5),
    "ball": ("ball diameter over the pitch diameter", 0.12),
    "pressing": ("semi-axis of the contact ellipses over the ball's radius", 0.15),
    "preload": ("loads on the less loaded pair of flanks over those on the other", 0.6),
    "spread": ("standard deviation of the contact loads over their mean", 0.5),
    "lost": ("share of the loaded contacts that carry less than 15 % of the mean load", 0.4),
    "one side": ("nut fixed at one face", 1.0),
    "outside": ("nut fixed at its outer surface", 1.0),
    "low face": ("nearness of the balls to the nut's face at low z", 0.3),
    "high face": ("nearness of the balls to the nut's face at high z", 0.3),
    "moment": ("tilting moment on the contacts over the sum of their loads at the pitch radius", 0.1),
    "radial": ("lateral force on the contacts over the sum of their loads", 0.1),
    "angle": ("contact angle [deg]", 10.0),
    "screw": ("conformity of the screw's groove", 0.02),
    "nut": ("conformity of the nut's groove", 0.02),
    "turn": ("angle between neighbouring balls [rad]", 0.3),
    "few": ("one over the number of balls", 0.2),
}

#: Feature that only scenes with a nut fixed at its flange have. Their errors are estimated from those of all screws, with
#: this feature; errors of other screws are estimated from screws without a flange.
FLANGE = "flange"

#: Definition and scale of each feature, with the feature `FLANGE`.
WITH_FLANGE = SCALES | {FLANGE: ("nut fixed at its flange", 1.0)}


@result_record
class ExpectedModelErrors:
    """Expected error of a model for one scene, estimated from its errors against the 3D reference on other scenes.

    Percentages are None if no similar scene was compared: the scene is then "not covered".
    """

    #: Largest error of a contact load [% of the mean contact load].
    percent: float | None = quantity_field(
        "covered",
        "whether scenes like this one were compared with the 3D reference",
        QuantityDescription(
            "largest_percent_of_mean",
            "largest error of a contact load to expect, in per cent of the mean load; at least nine of ten compared scenes "
            "had a smaller one",
        ),
        show=lambda percent: percent is not None,
    )
    #: Root mean square error of the contact loads [% of the mean contact load].
    rms_percent: float | None = quantity_field("rms_percent_of_mean", "expected RMS error of all contact loads")
    #: Distance to the nearest compared scene: Euclidean norm of the differences of the features, each divided by its scale
    #: (`SCALES`).
    distance: float = quantity_field(
        "distance", "distance to the most similar compared scene in the features that decide the error, in scaled units"
    )
    #: Name of the nearest compared scene; empty if there is none.
    nearest: str = quantity_field("nearest", "name of the most similar compared scene")
    #: Number of compared scenes of the same kind (screws or bearings).
    compared: int = quantity_field("compared", "number of compared scenes of the same kind (screws or bearings)")
    #: Sentences: how the model describes the elasticity of screw, nut and balls, and in what the scene differs from the
    #: compared scenes.
    words: tuple[str, ...] = quantity_field("words")
    #: Error of the axial displacement of the cross-section on which the axial load acts [%].
    displacement_percent: float | None = quantity_field(
        "displacement_percent", "expected error of the axial displacement", default=None
    )
    #: Error of the axial tangent rigidity of the cross-section on which the axial load acts [%].
    rigidity_percent: float | None = quantity_field(
        "rigidity_percent", "expected error of the tangent rigidity", default=None
    )
    #: Error of the largest pressure against that by Hertz from the contact loads of the 3D reference [%].
    pressure_percent: float | None = quantity_field(
        "pressure_percent", "expected error of the largest pressure", default=None
    )


@dataclass(frozen=True)
class MeasuredModelErrors:
    """Measured errors [%] of a low-order model against the 3D reference on one scene, and the features of the scene.

    Errors that were not measured are None.
    """

    #: Name of the scene.
    scene: str
    #: Name of the low-order model.
    model: str
    #: Largest error of a contact load [% of the mean load].
    percent: float
    #: Root mean square error of the contact loads [% of the mean load].
    rms_percent: float
    #: Numbers that describe the scene, by name, as `features_of_scene` returns them.
    features: dict[str, float]
    #: Error of the axial displacement of the cross-section on which the axial load acts [%].
    displacement_percent: float | None = None
    #: Error of the axial tangent rigidity of the cross-section on which the axial load acts [%].
    rigidity_percent: float | None = None
    #: Error of the largest contact pressure [%].
    pressure_percent: float | None = None
    #: Largest error of a contact load in per cent of the reference load of that contact (of the mean load for small loads),
    #: which `rollbench check` compares with the error limit.
    gate_percent: float | None = None


def lateral_force_and_tilting_moment(scene: Scene, result: StaticResult) -> tuple[float, float]:
    """Return the lateral force [N] and the tilting moment about the nut's centre [N m] that the screw's contacts carry.

    ``result``: converged solution of the scene.

    Force and moment include the effects of loads anywhere on the shaft, of their lever arms and of displaced supports. At
    least one contact must carry load.
    """
    touching = result.load[:, :2] > 0.0
    forces = (result.load[:, :2, None] * result.force_direction[:, :2])[touching]
    arms = result.contact_point[:, :2][touching] - np.array([0.0, 0.0, scene.nut.position])
    force, moment = forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)
    return float(np.hypot(*force[:2])), float(np.hypot(*moment[:2]))


def features_of_scene(scene: Scene, result: StaticResult) -> dict[str, float]:
    """Compute the features (`SCALES`) that describe a scene for the estimate of a model's error.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Converged result of a model for the scene.

    Returns
    -------
    dict
        Value of each feature by its name.

    Raises
    ------
    ValueError
        If no dimensions of the 3D parts follow from the scene (`meshes.solid.dimensions_of_3d_parts`).
    """
    dims, R, layout, load = dimensions_of_3d_parts(scene), scene.track.pitch_radius, ball_layout(scene), result.load
    flank_means = np.sort(np.array([load[:, [0, 3]].mean(), load[:, [1, 2]].mean()]))
    main = load[:, [0, 3]] if load[:, 0].sum() >= load[:, 1].sum() else load[:, [1, 2]]
    mean, total = float(main.mean()), max(float(load.sum()), 1e-300)
    touching = load > 0.0
    size = float(hertz_without_errors(scene).C_a.mean()) * float(np.cbrt(mean))
    z, half, radius = layout.z - scene.nut.position, scene.nut.length / 2.0, scene.balls.radius
    across, tilting = lateral_force_and_tilting_moment(scene, result)
    return {
        "wall": (scene.nut.outer_diameter / 2.0 - dims.land) / R,
        "length": scene.nut.length / (2.0 * R),
        "bore": scene.screw.bore / (2.0 * R),
        "lead": scene.track.lead / (2.0 * R),
        "ball": radius / R,
        "pressing": size / radius,
        "preload": float(flank_means[0] / flank_means[1]) if flank_means[1] > 0.0 else 0.0,
        "spread": float(main.std() / mean) if mean > 0.0 else 0.0,
        "lost": float((load[touching] < 0.15 * mean).mean()) if touching.any() else 0.0,
        "one side": float(dims.nut_held in ("left face", "right face")),
        "outside": float(dims.nut_held == "outer surface"),
        "low face": float(np.exp(1.0 - (half + z.min()) / radius)),
        "high face": float(np.exp(1.0 - (half - z.max()) / radius)),
        "moment": tilting / (total * R),
        "radial": across / total,
        "angle": float(np.degrees(scene.track.contact_angle)),
        "screw": scene.screw.groove_radius / (2.0 * radius),
        "nut": scene.nut.groove_radius / (2.0 * radius),
        "turn": _median(np.diff(np.sort(layout.azimuth))) if scene.ball_count > 1 else 2.0 * np.pi,
        "few": 1.0 / scene.ball_count,
        **({FLANGE: 1.0} if is_nut_fixed_at_flange(scene) else {}),
    }


def _median(values: Array) -> float:
    """Return the median of the numbers in an array.

    `numpy.median` is not used because it imports masked arrays, which takes time.
    """
    ordered = np.sort(values)
    return float(0.5 * (ordered[(ordered.size - 1) // 2] + ordered[ordered.size // 2]))


def _scaled_features(features: dict[str, float], scales: Mapping[str, tuple[str, float]]) -> Array:
    """Return the k features of a scene as an array (k,), each divided by its scale; a missing feature counts as zero.

    ``features``: features by name; ``scales``: definition and scale of each feature by its name, as in `SCALES`.
    """
    return np.array([features.get(name, 0.0) / unit for name, (_, unit) in scales.items()])


def save_model_errors(folder: Path, measured_errors: Sequence[MeasuredModelErrors]) -> None:
    """Write measured errors of models on compared scenes to the file `FILE` in a folder."""
    text = json.dumps([asdict(p) for p in measured_errors], indent=1, sort_keys=True) + "\n"
    files.replace_file(folder / FILE, text)


@cache
def model_errors_on_compared_scenes() -> tuple[MeasuredModelErrors, ...]:
    """Return the measured errors of the models on the built-in scenes, then on the randomly drawn screws.

    The errors are read from files that are included with rollbench; a missing or damaged file contributes nothing.
    """
    built_in = _measured_errors_from_json(lambda: json.loads(files.shipped_text(f"references/{FILE}")))
    return (*built_in, *model_errors_on_random_screws())


@cache
def model_errors_on_random_screws() -> tuple[MeasuredModelErrors, ...]:
    """Return the stored errors of the models on the randomly drawn screws; empty if their file is missing or damaged."""
    return _measured_errors_from_json(lambda: [x for scene in survey_records_of_random_screws() for x in scene["points"]])


def _measured_errors_from_json(read_records: Callable[[], Iterable[dict[str, Any]]]) -> tuple[MeasuredModelErrors, ...]:
    """Return the measured errors of models on scenes from JSON records; empty if the records cannot be read.

    ``read_records``: function that reads the records, each with the fields of `MeasuredModelErrors`.
    """
    try:
        points = tuple(MeasuredModelErrors(**row) for row in read_records())
        return tuple(p for p in points if set(p.features) - {FLANGE} == set(SCALES))
    except (OSError, ValueError, TypeError, KeyError):
        return ()


def why_no_similar_scene_was_compared(scene: Scene) -> str:
    """Return why no scene like this one was compared with the 3D reference (such as a rigid nut); empty if some were."""
    if scene.solid.nut == "rigid":
        return "its nut is rigid; the nuts of all compared scenes are elastic"
    if scene.ingredients.screw == "rigid" and scene.track.lead > 0.0:
        return "its screw is rigid; the screws of all compared scenes with a lead are elastic"
    if scene.nut.flange is not None and not is_nut_fixed_at_flange(scene):
        return "its nut has a flange but is not fixed at it; flanged nuts of compared scenes are"
    return ""


def is_nut_fixed_at_flange(scene: Scene) -> bool:
    """Return whether the nut of the scene has a flange and is fixed at the face of the flange."""
    return scene.nut.flange is not None and scene.solid.nut_held in (None, "flange face")


def upper_bound_of_model_error(known: Array, errors: Array, place: Array, least_error: float) -> float:
    """Return an upper bound [%] of a model's error on a scene, estimated from its errors on compared scenes.

    The logarithm of the error is fitted as a linear function of the features. The logarithm of the bound is the value of
    this fit on the scene, plus the quantile `SHARE` of the leave-one-out residuals, so that the fraction `SHARE` of the
    compared scenes have errors below the bound that follows from all other scenes.

    Parameters
    ----------
    known
        The k features of the n compared scenes, each divided by its scale, (n, k).
    errors
        Errors of the model on these scenes, (n,) [%].
    place
        The k features of the scene, each divided by its scale, (k,).
    least_error
        Least error [%], to which smaller errors are raised before their logarithm is taken.
    """
    middle = known.mean(axis=0)
    A = np.column_stack([np.ones(len(known)), known - middle])
    y = np.log(np.maximum(np.abs(errors), least_error))
    solve = np.linalg.solve(A.T @ A + RIDGE * np.diag([0.0, *np.ones(known.shape[1])]), A.T)
    off = (y - A @ (solve @ y)) / (1.0 - np.einsum("ij,ji->i", A, solve))  # of a fit without the scene
    rank = min(int(np.ceil((len(y) + 1) * SHARE)), len(y))
    return float(np.exp(np.array([1.0, *(place - middle)]) @ (solve @ y) + np.sort(off)[rank - 1]))


def estimate_model_error(
    scene: Scene, result: StaticResult, measured_errors: Iterable[MeasuredModelErrors] | None = None
) -> ExpectedModelErrors:
    """Estimate the error of a model's result for a scene, from the model's errors against the 3D reference on other scenes.

    The estimate does not cover models that were not compared with the 3D reference (Mei's, those of users), kinds of scenes
    that were not compared (bearings are compared with bearings only), and scenes outside the range of the compared scenes.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    result
        Converged result of the model for the scene.
    measured_errors
        Measured errors of models on compared scenes; None: those included with rollbench.

    Returns
    -------
    ExpectedModelErrors
        The estimate, without percentages if the scene is not covered.
    """
    if result.model not in MODELS:
        return ExpectedModelErrors(None, None, float("inf"), "", 0, (WORDS, NOT_COMPARED))
    model = MODELS[result.model]
    ring, flanged = scene.track.lead == 0.0, is_nut_fixed_at_flange(scene)
    points = model_errors_on_compared_scenes() if measured_errors is None else measured_errors
    compared = [p for p in points if p.model == (model.model_with_same_errors or model.name)]
    scales = WITH_FLANGE if flanged else SCALES
    like = [p for p in compared if (p.features["lead"] == 0.0) == ring and (flanged or FLANGE not in p.features)]
    words: tuple[str, ...] = (model.elasticity_text,)

    def estimate_not_covered(why: str, away: float = float("inf"), nearest: str = "") -> ExpectedModelErrors:
        """Return an estimate without percentages for the reason ``why``.

        ``nearest``: name of the nearest scene compared with the 3D reference; ``away``: distance from it, the root of the
        sum of squared differences of the scaled features.
        """
        return ExpectedModelErrors(None, None, away, nearest, len(like), (*words, why))

    if not (result.load > 0.0).any():
        return estimate_not_covered("no contact carries load, so that errors in per cent of the mean load are not defined")
    try:
        place = _scaled_features(features_of_scene(scene, result), scales)
    except ValueError as error:
        return estimate_not_covered(f"not comparable: {error}")
    if not compared:
        return estimate_not_covered("no scene was compared with the 3D reference")
    other = why_no_similar_scene_was_compared(scene)
    if not other and sum(not flanged or FLANGE in p.features for p in like) < FEWEST:
        what = "bearings" if ring else "nuts held by a flange" if flanged else "screws"
        other = f"too few {what} were compared with the 3D reference"
    if other:
        return estimate_not_covered(other)
    known = np.array([_scaled_features(p.features, scales) for p in like])
    away = np.hypot.reduce(known - place, axis=1)  # hypot: does not overflow for a moment with nearly zero loads
    nearest = like[int(away.argmin())].scene
    unlike = "; ".join([*descriptors_outside_range(scene), *_definitions_of_features_outside_range(known, place)])
    if unlike:
        return estimate_not_covered(f"outside the range of the compared scenes: {unlike}", float(away.min()), nearest)
    expected = _expected_errors(like, known, place)
    return ExpectedModelErrors(distance=float(away.min()), nearest=nearest, compared=len(like), words=words, **expected)


def _definitions_of_features_outside_range(known: Array, place: Array) -> list[str]:
    """Return, as text, the definition of each feature in which a scene lies outside the range of the compared scenes.

    ``place``: the k features of the scene, each divided by its scale, (k,); ``known``: those of the n compared scenes,
    (n, k). A scene is outside if it exceeds the range by more than `MARGIN`.
    """
    far = np.maximum(known.min(axis=0) - place, place - known.max(axis=0)) > MARGIN
    return [what for (what, _), beyond in zip(WITH_FLANGE.values(), far, strict=False) if beyond]


def _expected_errors(like: Sequence[MeasuredModelErrors], known: Array, place: Array) -> dict[str, float | None]:
    """Return the expected error [%] of each quantity in `QUANTITIES` on a scene, from the errors on n similar scenes.

    ``like``: measured errors on these scenes; ``known``: their k features, each divided by its scale, (n, k); ``place``:
    those of the scene, (k,). An expected error is None if too few similar scenes have an error of this quantity.
    """
    out: dict[str, float | None] = dict.fromkeys(QUANTITIES)
    for name in QUANTITIES:
        errors = np.array([np.nan if (e := getattr(p, name)) is None else e for p in like], dtype=float)
        finite = np.isfinite(errors)
        if finite.sum() >= FEWEST:
            out[name] = upper_bound_of_model_error(known[finite], errors[finite], place, LEAST[name])
    return out


@dataclass(frozen=True)
class MeasuredAndExpectedErrors:
    """Errors of a model on one compared scene: as measured, and as estimated from all other compared scenes."""

    #: Measured errors of the model on the scene, with the features of the scene.
    point: MeasuredModelErrors
    #: Expected errors [%] by name of the quantity (`QUANTITIES`); None if the scene is outside the range of the other
    #: compared scenes.
    expected: dict[str, float | None] | None


def leave_one_out_errors(measured_errors: Sequence[MeasuredModelErrors], model: str) -> list[MeasuredAndExpectedErrors]:
    """Estimate the error of a model on each compared screw from its errors on all other compared screws.

    ``measured_errors``: measured errors of models on compared scenes; ``model``: name of the model. For a screw whose nut
    is not fixed at a flange, the error is estimated only from other such screws.
    """
    out = []
    for flange, scales in ((False, SCALES), (True, WITH_FLANGE)):
        screws = [p for p in measured_errors if p.model == model and p.features["lead"] > 0.0]
        like = [p for p in screws if flange or FLANGE not in p.features]
        known = np.array([_scaled_features(p.features, scales) for p in like])
        for k, point in enumerate(like):
            if (FLANGE in point.features) == flange:
                others, rest = [p for p in like if p is not point], np.delete(known, k, axis=0)
                outside = _definitions_of_features_outside_range(rest, known[k])
                expected = None if outside else _expected_errors(others, rest, known[k])
                out.append(MeasuredAndExpectedErrors(point, expected))
    return out


#: Scene with increased loads, the result of a model for it, and the run of the 3D reference for it.
Raised: TypeAlias = "tuple[Scene, StaticResult, Run]"


@dataclass(frozen=True)
class LoadedSectionState:
    """Axial displacement of the screw's cross-section on which the axial load acts, and axial force on the nut."""

    #: Axial displacement of the cross-section [m].
    axial_displacement: float
    #: Axial force of the screw on the nut [N].
    axial_force: float


def state_of_loaded_section(scene: Scene, solution: ContactSolution) -> LoadedSectionState:
    """Return the axial displacement of the screw's cross-section under the axial load, and the axial force on the nut.

    The cross-section is where the largest axial load acts, or the nut's centre if the scene has no loads.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    solution
        Contact loads and displacements by a model or a run of the 3D reference.

    Returns
    -------
    LoadedSectionState
        Axial displacement of this cross-section [m] and axial force on the nut [N].
    """
    place = max(scene.loads, key=lambda load: abs(load.force[2])).at if scene.loads else scene.nut.position
    moved = float(np.interp(place, solution.stations, solution.line[:, 2]))
    return LoadedSectionState(moved, axial_contact_force(scene, solution.load, np.radians(solution.angle)))


def axial_rigidity_between_states(first: LoadedSectionState, second: LoadedSectionState) -> float | None:
    """Return the axial rigidity [N/m] between two load states: change of force over change of displacement.

    None if the displacement does not change.
    """
    step = second.axial_displacement - first.axial_displacement
    return (second.axial_force - first.axial_force) / step if step != 0.0 else None


def axial_contact_force(scene: Scene, load: Array, angle: Array) -> float:
    """Return the axial force [N] of the screw on the nut, from contact loads and contact angles.

    ``load``: contact loads of n balls on 4 flanks, (n, 4) [N]; ``angle``: contact angles, (n, 4) [rad].
    """
    along = np.where(load > 0.0, load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    return float(along[0] - along[1])


def measure_model_error(
    name: str, scene: Scene, result: StaticResult, run: Run, increased_load_case: Raised | None = None
) -> MeasuredModelErrors:
    """Measure the errors of a model on a scene against a run of the 3D reference.

    Parameters
    ----------
    name
        Name of the scene.
    scene
        Scene with one nut or bearing row.
    result
        Result of the model.
    run
        Run of the 3D reference.
    increased_load_case
        The same scene under increased loads, with the model's result and the 3D run for it. The rigidities of model and 3D
        reference follow from the differences between the two load states; None: the rigidity is not compared.

    Returns
    -------
    MeasuredModelErrors
        Errors of the model, with the features of the scene.
    """
    error = load_error(result.load, run.load, count_nominal_contacts(scene))
    from rollbench.compare.models.comparison import solution_from_result, solution_from_run

    answer = state_of_loaded_section(scene, solution_from_result(result))
    reference = state_of_loaded_section(scene, solution_from_run(run, ""))
    stiff: tuple[float | None, float | None] = (None, None)
    if increased_load_case is not None:
        heavier, modelled, computed = increased_load_case
        by_model = state_of_loaded_section(heavier, solution_from_result(modelled))
        by_run = state_of_loaded_section(heavier, solution_from_run(computed, ""))
        stiff = axial_rigidity_between_states(answer, by_model), axial_rigidity_between_states(reference, by_run)
    heaviest = run.load.max()
    return MeasuredModelErrors(
        name,
        result.model,
        round(error.max_percent, 4),
        round(error.rms_percent, 4),
        {name: round(value, 4) for name, value in features_of_scene(scene, result).items()},
        error_percent_or_none(answer.axial_displacement, reference.axial_displacement),
        error_percent_or_none(*stiff),
        error_percent_or_none(np.cbrt(result.load.max() / heaviest), 1.0) if heaviest > 0.0 else None,  # Hertz
        gate_percent=round(error.gate_percent, 4),
    )


def error_percent_or_none(value: float | None, reference: float | None) -> float | None:
    """Return the error of ``value`` [% of ``reference``]; None if one of them is None, or if ``reference`` is zero."""
    return None if value is None or not reference else round(float(error_percent(value, reference)), 4)
