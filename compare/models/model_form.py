"""Expected error of a low-order model, estimated from its errors against the 3D reference on other scenes.

Each scene is described by dimensionless features (`SCALES`). On the compared scenes, which are included with rollbench or
generated at random, the errors of the model were measured. The logarithm of an error is fitted as a linear function of the
features, by ridge regression to avoid steep slopes with few scenes. The expected error is the fitted error times a factor.

The factor is calibrated on scenes that the fit does not know (split conformal prediction: Vovk, Gammerman and Shafer 2005;
Lei, G'Sell, Rinaldo, Tibshirani and Wasserman 2018, theorem 2.2). Of n calibrating scenes, it is the one of rank
ceil((n + 1) `SHARE`) among the ratios of measured to fitted error. Whatever the fit and the distribution of the errors, the
error of a new scene is then below the expected one with a probability of at least `SHARE`, if the new scene and the
calibrating ones are exchangeable, for example drawn independently from the same distribution. The probability is one over
all draws of the calibrating scenes and the new one together; it is not one for each single kind of screw. Nuts without a
flange, nuts fixed at their flange, and double nuts are calibrated separately, each on scenes of its own kind; the ratio of
a double nut is that of its larger error to its larger fitted error. The screws of users are not drawn like the compared
ones: for them, the share is an assumption. A scene outside the range of the compared scenes is "not covered".

Where too few scenes calibrate (models that were compared on the built-in scenes only), the factor follows from the errors
that fits without each scene leave on it. No theorem guarantees a share then (Barber, Candes, Ramdas and Tibshirani 2021).

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
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from rollbench.compare import files
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models import applicability
from rollbench.compare.models.applicability import CALIBRATING, descriptors_outside_range
from rollbench.compare.models.registry import MODELS
from rollbench.compare.models.user_models import NOT_COMPARED, WORDS
from rollbench.lowfi.rating.catalogue_checks import ShaftLimits, shaft_limits
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record
from rollbench.meshes.solid import dimensions_of_3d_parts

if TYPE_CHECKING:
    from rollbench.compare.models.comparison import ContactSolution
    from rollbench.compare.reference.store import Run

#: File with the errors on built-in scenes, in a folder of 3D reference runs.
FILE = "model_form.json"

#: Fields of `MeasuredModelErrors` with the errors that are estimated, each separately: largest and RMS error of the contact
#: loads (in per cent of the mean load), errors of axial displacement and tangent rigidity of the cross-section on which the
#: axial load acts, error of the largest pressure.
QUANTITIES = ("percent", "rms_percent", "displacement_percent", "rigidity_percent", "pressure_percent")

#: Fields of `ExpectedError` with the estimates of `QUANTITIES`, in the same order.
EXPECTED = ("loads", "loads_rms", "displacement", "rigidity", "pressure")

#: Probability with which the error of a new scene is at least below the expected one, a little above nine in ten.
SHARE = 0.92

#: Names of the drawn screws that calibrate the expected errors; no error is fitted from them.
CALIBRATING_SCREWS = frozenset(f"survey {number}" for number in CALIBRATING)

#: Compression of the shaft over its buckling load (of compared scenes: up to 0.24) from which on no error is expected:
#: neither the models nor the 3D reference know that a compressed shaft bends more.
NEAR_BUCKLING = 0.3

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

#: Feature that only the nuts of double nuts have. It is not fitted: double nuts only calibrate.
DOUBLE = "double nut"

#: Definition and scale of each feature, with the feature `FLANGE`.
WITH_FLANGE = SCALES | {FLANGE: ("nut fixed at its flange", 1.0)}


@result_record
class ExpectedError:
    """Expected error of a model for one scene, estimated from its errors against the 3D reference on other scenes.

    Percentages are None if no similar scene was compared: the scene is then "not covered".
    """

    #: Largest error of a contact load [% of the mean contact load].
    loads: float | None = quantity_field(
        "covered",
        "whether scenes like this one were compared with the 3D reference",
        QuantityDescription(
            "largest_percent_of_mean",
            "largest error of a contact load to expect, in per cent of the mean load; nine in ten new scenes like those "
            "that calibrate it have a smaller one",
        ),
        show=lambda loads: loads is not None,
    )
    #: Root mean square error of the contact loads [% of the mean contact load].
    loads_rms: float | None = quantity_field("rms_percent_of_mean", "expected RMS error of all contact loads")
    #: Distance to the nearest compared scene, the Euclidean norm of the differences of the features, each divided by its
    #: scale (`SCALES`).
    distance: float = quantity_field(
        "distance", "distance to the most similar compared scene in the features that decide the error, in scaled units"
    )
    #: Name of the nearest compared scene; empty if there is none.
    nearest: str = quantity_field("nearest", "name of the most similar compared scene")
    #: Number of compared scenes of the same kind (screws or bearings).
    compared: int = quantity_field("compared", "number of compared scenes of the same kind (screws or bearings)")
    #: Number of compared scenes that calibrate the errors and are not fitted; 0 if too few for this model or kind.
    calibrated: int = quantity_field(
        "calibrated_on", "number of the compared scenes, unknown to the fit, that calibrate the errors; 0: no such scenes"
    )
    #: Sentences on how the model describes the elasticity of screw, nut and balls, and in what the scene differs from the
    #: compared scenes.
    words: tuple[str, ...] = quantity_field("words")
    #: Error of the axial displacement of the cross-section on which the axial load acts [%].
    displacement: float | None = quantity_or_none("displacement_percent", "expected error of the axial displacement")
    #: Error of the axial tangent rigidity of the cross-section on which the axial load acts [%].
    rigidity: float | None = quantity_or_none("rigidity_percent", "expected error of the tangent rigidity")
    #: Error of the largest pressure against that by Hertz from the contact loads of the 3D reference [%].
    pressure: float | None = quantity_or_none("pressure_percent", "expected error of the largest pressure")


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

    @property
    def kind(self) -> str:
        """Kind of the scene, a key of `NAMES_OF_KINDS`."""
        kinds = (kind for kind in (FLANGE, DOUBLE) if kind in self.features)
        return next(kinds, "ring" if self.features["lead"] == 0.0 else "screw")

    @property
    def described_scene(self) -> str:
        """Name of the scene, which two nuts of a double nut share."""
        return self.scene.partition(",")[0] if self.kind == DOUBLE else self.scene

    @property
    def calibrates(self) -> bool:
        """Whether the errors calibrate the expected ones, and are not fitted."""
        return self.kind == DOUBLE or self.scene in CALIBRATING_SCREWS


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
    """Return the measured errors of the models on the built-in scenes, then on the drawn screws, then on the double nuts.

    The errors are read from files that are included with rollbench; a missing or damaged file contributes nothing.
    """
    built_in = _measured_errors_from_json(lambda: json.loads(files.shipped_text(f"references/{FILE}")))
    return (*built_in, *model_errors_on_random_screws(), *model_errors_on_random_screws(applicability.DOUBLE_NUT_SURVEY))


@cache
def model_errors_on_random_screws(file: str = applicability.SURVEY) -> tuple[MeasuredModelErrors, ...]:
    """Return the stored errors of the models on the randomly drawn screws; empty if their file is missing or damaged.

    ``file``: name of the file with the screws, or with the double nuts.
    """
    return _measured_errors_from_json(
        lambda: [x for scene in applicability.survey_records_of_random_screws(file) for x in scene["points"]]
    )


def _measured_errors_from_json(read_records: Callable[[], Iterable[dict[str, Any]]]) -> tuple[MeasuredModelErrors, ...]:
    """Return the measured errors of models on scenes from JSON records; empty if the records cannot be read.

    ``read_records``: function that reads the records, each with the fields of `MeasuredModelErrors`.
    """
    try:
        points = tuple(MeasuredModelErrors(**row) for row in read_records())
        return tuple(p for p in points if set(p.features) - {FLANGE, DOUBLE} == set(SCALES))
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


@dataclass(frozen=True)
class LogErrorFit:
    """Fit of the logarithms of a model's errors on n compared scenes as a linear function of their features."""

    #: Mean of each of the k features, (k,).
    middle: Array
    #: Coefficients: the constant, then the slope of each feature, (k + 1,).
    coefficients: Array
    #: Residual on each scene of a fit without this scene, (n,).
    residuals_without_scene: Array

    def fitted(self, places: Array) -> Array:
        """Return the fitted logarithms at m places, given by their k features, (m, k)."""
        return np.column_stack([np.ones(len(places)), places - self.middle]) @ self.coefficients


def fit_log_errors(known: Array, log_errors: Array) -> LogErrorFit:
    """Fit logarithms of errors on n scenes, (n,), to their k features, each divided by its scale, (n, k)."""
    middle = known.mean(axis=0)
    A = np.column_stack([np.ones(len(known)), known - middle])
    solve = np.linalg.solve(A.T @ A + RIDGE * np.diag([0.0, *np.ones(known.shape[1])]), A.T)
    coefficients = solve @ log_errors
    off = (log_errors - A @ coefficients) / (1.0 - np.einsum("ij,ji->i", A, solve))
    return LogErrorFit(middle, coefficients, off)


#: Errors [%] of a model in one quantity on the m nuts of a scene (m = 1 for most), (m,), and their features, (m, k).
NutErrors: TypeAlias = "tuple[Array, Array]"


def upper_bound_of_model_error(
    known: Array, errors: Array, places: Array, least_error: float, calibrating: Sequence[NutErrors] = ()
) -> float:
    """Return an upper bound [%] of a model's error on a scene, estimated from its errors on compared scenes.

    The logarithm of the error is fitted as a linear function of the features. The logarithm of the bound is the value of
    this fit on the scene plus a quantile of the differences between measured and fitted logarithms: on the calibrating
    scenes; if these are too few, on the fitted scenes by fits without each.

    Parameters
    ----------
    known
        The k features of the n fitted scenes, each divided by its scale, (n, k).
    errors
        Errors of the model on these scenes, (n,) [%].
    places
        The k features of each of the m nuts of the scene, each divided by its scale, (m, k).
    least_error
        Least error [%], to which smaller errors are raised before their logarithm is taken.
    calibrating
        Errors and features of each calibrating scene.
    """

    def logarithms(values: Array) -> Array:
        return np.asarray(np.log(np.maximum(np.abs(values), least_error)))

    fit = fit_log_errors(known, logarithms(errors))
    off = np.array([logarithms(e).max() - fit.fitted(at).max() for e, at in calibrating])
    if calibration_rank(off.size) > off.size:
        off = fit.residuals_without_scene
    rank = min(calibration_rank(off.size), off.size)
    return float(np.exp(fit.fitted(places).max() + np.sort(off)[rank - 1]))


def calibration_rank(count: int) -> int:
    """Return the rank of the calibrating ratio that is the factor, of ``count`` in ascending order; above it: too few."""
    return int(np.ceil((count + 1) * SHARE))


def estimate_model_error(
    scene: Scene, result: StaticResult, measured_errors: Iterable[MeasuredModelErrors] | None = None
) -> ExpectedError:
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
    ExpectedError
        The estimate, without percentages if the scene is not covered.
    """
    return _estimate_model_error([(scene, result)], result.model, shaft_limits(scene, result), "", measured_errors)


def estimate_double_nut_error(
    assembly: Assembly, result: AxisResult, measured_errors: Iterable[MeasuredModelErrors] | None = None
) -> ExpectedError:
    """Estimate the error of a model's result for a double nut, from its errors on compared screws and double nuts.

    Errors of contact loads are in per cent of the mean load of their own nut; displacement and rigidity are those of the
    shaft's cross-section on which the axial load acts. A shaft with other sets than two ball nuts is not covered.

    ``result``: converged result of the model; ``measured_errors``: as in `estimate_model_error`.
    """
    if [s.kind for s in assembly.sets] != ["ball nut", "ball nut"]:
        why = "of several nuts or bearings on one shaft, only double nuts were compared"
        return ExpectedError(None, None, float("inf"), "", 0, 0, (why,))
    nuts, unlike = nuts_of_double_nut(assembly, result), _unlike_compared_double_nuts(assembly)
    return _estimate_model_error(nuts, result.model, shaft_limits(assembly, result, nuts[0][0]), unlike, measured_errors)


def nuts_of_double_nut(assembly: Assembly, result: AxisResult) -> list[tuple[Scene, StaticResult]]:
    """Return each nut on a shaft as a scene with the shaft's loads and supports, and the shaft's result for it."""
    names = ("equilibrium", "reactions", "model", "centreline_z", "centreline")
    shared: dict[str, Any] = {name: getattr(result, name) for name in names}
    return [
        (replace(s.of.parts, supports=assembly.supports, loads=assembly.loads), replace(s.balls, **shared))
        for s in result.sets
        if isinstance(s.of.parts, Scene) and s.balls is not None
    ]


def _unlike_compared_double_nuts(assembly: Assembly) -> str:
    """Return, as text, what a shaft with two nuts has that no compared double nut has; empty: nothing."""
    first, second = (s.parts for s in assembly.sets)
    assert isinstance(first, Scene)
    assert isinstance(second, Scene)
    alike = {(x.track, replace(x.nut, position=0.0), x.balls) for x in (first, second)}
    moved = {s.offset for s in assembly.sets}
    differences = {
        "its shaft is warmed": assembly.thermal_strain != 0.0,
        "its shaft has segments without groove": bool(assembly.segments),
        "its nuts sit in housings that can move": any(s.housing or s.carrier for s in assembly.sets),
        "its nuts are not braced against each other": not any(s.preload for s in assembly.sets) and len(moved) == 1,
        "its nuts are not equal": len(alike) > 1,
    }
    return "; ".join(words for words, given in differences.items() if given)


def _estimate_model_error(
    nuts: Sequence[tuple[Scene, StaticResult]],
    model_name: str,
    limits: ShaftLimits | None,
    unlike_compared: str,
    measured_errors: Iterable[MeasuredModelErrors] | None,
) -> ExpectedError:
    """Estimate the error of a model on a scene with one nut or bearing, or on a double nut.

    ``nuts``: each nut as a scene, with the model's result for it; ``limits``: limits of the shaft; ``unlike_compared``:
    what the scene has that no compared scene has, as text, empty for nothing; ``measured_errors``: as in
    `estimate_model_error`.
    """
    if model_name not in MODELS:
        return ExpectedError(None, None, float("inf"), "", 0, 0, (WORDS, NOT_COMPARED))
    model, scene = MODELS[model_name], nuts[0][0]
    kind = kind_of_scene(scene, double=len(nuts) > 1)
    points = model_errors_on_compared_scenes() if measured_errors is None else measured_errors
    compared = [p for p in points if p.model == (model.model_with_same_errors or model.name)]
    like = ScenesLike.of_kind(kind, compared)
    words: tuple[str, ...] = (model.elasticity_text,)

    def estimate_not_covered(why: str, away: float = float("inf"), nearest: str = "") -> ExpectedError:
        """Return an estimate without percentages for the reason ``why``.

        ``nearest``: name of the nearest scene compared with the 3D reference; ``away``: distance from it, the root of the
        sum of squared differences of the scaled features.
        """
        return ExpectedError(None, None, away, nearest, like.count, 0, (*words, why))

    if not all((result.load > 0.0).any() for _, result in nuts):
        return estimate_not_covered("no contact carries load, so that errors in per cent of the mean load are not defined")
    try:
        places = np.array([_scaled_features(features_of_scene(*one), like.scales) for one in nuts])
    except ValueError as error:
        return estimate_not_covered(f"not comparable: {error}")
    if not compared:
        return estimate_not_covered("no scene was compared with the 3D reference")
    other = next(filter(None, (why_no_similar_scene_was_compared(one) for one, _ in nuts)), "")
    if not other and sum(p.kind == kind for p in like.points) < FEWEST:
        other = f"too few {NAMES_OF_KINDS[kind]} were compared with the 3D reference"
    if other:
        return estimate_not_covered(other)
    alike = like.in_range
    known = np.array([_scaled_features(p.features, like.scales) for p in alike])
    away = np.array([np.hypot.reduce(known - place, axis=1).min() for place in places])  # hypot: does not overflow
    farthest = int(away.argmax())
    nearest = alike[int(np.hypot.reduce(known - places[farthest], axis=1).argmin())].scene
    outside = [
        words
        for (one, _), place in zip(nuts, places, strict=True)
        for words in (*descriptors_outside_range(one), *_definitions_of_features_outside_range(known, place))
    ]
    if limits is not None and limits.compression > NEAR_BUCKLING * limits.buckling:
        share = f"{100.0 * limits.compression / limits.buckling:.0f} % of the load under which it buckles"
        outside.append(f"the shaft is compressed by {share}, more than {100.0 * NEAR_BUCKLING:.0f} %")
    unlike = "; ".join(filter(None, dict.fromkeys([unlike_compared, *outside])))
    if unlike:
        return estimate_not_covered(f"outside the range of the compared scenes: {unlike}", float(away.max()), nearest)
    expected = _expected_errors(like, places)
    scenes, count = like.calibrating, like.count
    enough = calibration_rank(len(scenes)) <= len(scenes)
    return ExpectedError(
        distance=float(away.max()),
        nearest=nearest,
        compared=count,
        calibrated=enough * len(scenes),
        words=words,
        **dict(zip(EXPECTED, expected.values(), strict=True)),
    )


#: Kinds of scenes whose errors are calibrated separately, with their names in sentences.
NAMES_OF_KINDS = {"ring": "bearings", "screw": "screws", FLANGE: "nuts held by a flange", DOUBLE: "double nuts"}


def kind_of_scene(scene: Scene, *, double: bool = False) -> str:
    """Return the kind of a scene, a key of `NAMES_OF_KINDS`; ``double``: whether it is a nut of a double nut."""
    return "ring" if scene.track.lead == 0.0 else DOUBLE if double else FLANGE if is_nut_fixed_at_flange(scene) else "screw"


@dataclass(frozen=True)
class ScenesLike:
    """Compared scenes from which the errors of scenes of one kind are estimated."""

    #: Kind, a key of `NAMES_OF_KINDS`.
    kind: str
    #: Measured errors on all these scenes; several for a scene with several nuts.
    points: tuple[MeasuredModelErrors, ...]

    @classmethod
    def of_kind(cls, kind: str, points: Iterable[MeasuredModelErrors]) -> ScenesLike:
        """Return those of the compared scenes that are fitted for a kind, and those that calibrate it.

        Nuts at their flange and double nuts are fitted from screws too.
        """
        fitted = {kind} if kind != FLANGE else {"screw", FLANGE}
        fitted |= {"screw"} if kind == DOUBLE else set()
        return cls(kind, tuple(p for p in points if p.kind in fitted and (p.kind == kind or not p.calibrates)))

    @property
    def scales(self) -> dict[str, tuple[str, float]]:
        """Definition and scale of each feature that counts for this kind."""
        return WITH_FLANGE if self.kind == FLANGE else SCALES

    @property
    def in_range(self) -> tuple[MeasuredModelErrors, ...]:
        """Errors on the scenes whose features are the range of this kind: double nuts among themselves."""
        return tuple(p for p in self.points if p.kind == self.kind) if self.kind == DOUBLE else self.points

    @property
    def fitted(self) -> list[MeasuredModelErrors]:
        """Errors that are fitted."""
        return [p for p in self.points if not p.calibrates]

    @property
    def calibrating(self) -> list[list[MeasuredModelErrors]]:
        """Errors on each calibrating scene of this kind."""
        scenes: dict[str, list[MeasuredModelErrors]] = {}
        for p in self.points:
            if p.calibrates:
                scenes.setdefault(p.described_scene, []).append(p)
        return list(scenes.values())

    @property
    def count(self) -> int:
        """Number of scenes."""
        return len({p.described_scene for p in self.points})


def _definitions_of_features_outside_range(known: Array, place: Array) -> list[str]:
    """Return, as text, the definition of each feature in which a scene lies outside the range of the compared scenes.

    ``place``: the k features of the scene, each divided by its scale, (k,); ``known``: those of the n compared scenes,
    (n, k). A scene is outside if it exceeds the range by more than `MARGIN`.
    """
    far = np.maximum(known.min(axis=0) - place, place - known.max(axis=0)) > MARGIN
    return [what for (what, _), beyond in zip(WITH_FLANGE.values(), far, strict=False) if beyond]


def _expected_errors(like: ScenesLike, places: Array) -> dict[str, float | None]:
    """Return the expected error [%] of each quantity in `QUANTITIES` on a scene, from the errors on similar scenes.

    ``places``: the k features of each of the scene's m nuts, each divided by its scale, (m, k). An expected error is None
    if too few similar scenes have an error of this quantity.
    """
    out: dict[str, float | None] = dict.fromkeys(QUANTITIES)

    def errors_and_features(points: Iterable[MeasuredModelErrors], name: str) -> NutErrors:
        """Return the known errors of the quantity ``name``, and the scaled features of their scenes."""
        known = [p for p in points if getattr(p, name) is not None]
        return np.array([getattr(p, name) for p in known]), np.array(
            [_scaled_features(p.features, like.scales) for p in known]
        )

    for name in QUANTITIES:
        errors, known = errors_and_features(like.fitted, name)
        calibrating = [pair for nuts in like.calibrating if (pair := errors_and_features(nuts, name))[0].size]
        if errors.size >= FEWEST:
            out[name] = upper_bound_of_model_error(known, errors, places, LEAST[name], calibrating)
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
    is not fixed at a flange, the error is estimated only from other such screws. Double nuts are left out.
    """
    points = [p for p in measured_errors if p.model == model and p.features["lead"] > 0.0]
    out = []
    for kind in ("screw", FLANGE):
        like = ScenesLike.of_kind(kind, points)
        known = np.array([_scaled_features(p.features, like.scales) for p in like.points])
        for k, point in enumerate(like.points):
            if point.kind == kind:
                others = ScenesLike(kind, (*like.points[:k], *like.points[k + 1 :]))
                outside = _definitions_of_features_outside_range(np.delete(known, k, axis=0), known[k])
                expected = None if outside else _expected_errors(others, known[k : k + 1])
                out.append(MeasuredAndExpectedErrors(point, expected))
    return out


#: Scene with increased loads, the result of a model for it, and the run of the 3D reference for it.
Raised: TypeAlias = "tuple[Scene, StaticResult, Run]"


#: Axial displacement [m] of the screw's cross-section on which the axial load acts, and axial force on the nut [N].
State: TypeAlias = "tuple[float, float]"


def state_of_loaded_section(scene: Scene, solution: ContactSolution) -> State:
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
    tuple
        Axial displacement of this cross-section [m] and axial force on the nut [N].
    """
    place = max(scene.loads, key=lambda load: abs(load.force[2])).at if scene.loads else scene.nut.position
    moved = float(np.interp(place, solution.stations, solution.line[:, 2]))
    return moved, axial_contact_force(scene, solution.load, np.radians(solution.angle))


def axial_rigidity_between_states(*states: State) -> float | None:
    """Return the axial rigidity [N/m] between two load states: change of force over change of displacement.

    None if the displacement does not change, or with a single state.
    """
    if len(states) < 2 or states[0][0] == states[1][0]:
        return None
    return (states[1][1] - states[0][1]) / (states[1][0] - states[0][0])


def _axial_errors(by_model: Sequence[State], by_run: Sequence[State]) -> dict[str, float | None]:
    """Return the errors [%] of displacement and tangent rigidity of a loaded section.

    ``by_model``, ``by_run``: its states by the model and by the 3D reference, under the loads and, if they are to be
    compared in rigidity, under increased loads.
    """
    stiff = (axial_rigidity_between_states(*states) for states in (by_model, by_run))
    return {
        "displacement_percent": error_percent_or_none(by_model[0][0], by_run[0][0]),
        "rigidity_percent": error_percent_or_none(*stiff),
    }


def axial_contact_force(scene: Scene, load: Array, angle: Array) -> float:
    """Return the axial force [N] of the screw on the nut, from contact loads and contact angles.

    ``load``: contact loads of n balls on 4 flanks, (n, 4) [N]; ``angle``: contact angles, (n, 4) [rad].
    """
    along = np.where(load > 0.0, load * np.sin(angle), 0.0).sum(axis=0) * np.cos(lead_angle(scene.track))
    return float(along[0] - along[1])


def measure_model_error(
    name: str,
    scene: Scene,
    result: StaticResult,
    run: Run,
    increased_load_case: Raised | None = None,
    contacts: int | None = None,
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
    contacts
        Number of contacts that carry load without geometric errors; None: that of ``scene`` alone.

    Returns
    -------
    MeasuredModelErrors
        Errors of the model, with the features of the scene.
    """
    error = load_error(result.load, run.load, count_nominal_contacts(scene) if contacts is None else contacts)
    from rollbench.compare.models.comparison import solution_from_result, solution_from_run

    cases = [(scene, result, run), *([] if increased_load_case is None else [increased_load_case])]
    by_model = [state_of_loaded_section(one, solution_from_result(found)) for one, found, _ in cases]
    by_run = [state_of_loaded_section(one, solution_from_run(computed, "")) for one, _, computed in cases]
    heaviest = run.load.max()
    return MeasuredModelErrors(
        name,
        result.model,
        round(error.max_percent, 4),
        round(error.rms_percent, 4),
        {name: round(value, 4) for name, value in features_of_scene(scene, result).items()},
        **_axial_errors(by_model, by_run),
        pressure_percent=error_percent_or_none(np.cbrt(result.load.max() / heaviest), 1.0) if heaviest > 0.0 else None,
        gate_percent=round(error.gate_percent, 4),
    )


def errors_of_shaft_section(
    assembly: Assembly, raised: Assembly, results: tuple[AxisResult, AxisResult], runs: Sequence[Run]
) -> dict[str, float | None]:
    """Return the errors [%] of displacement and tangent rigidity of the section of a shaft on which the axial load acts.

    ``assembly``, ``raised``: the shaft under its loads and under raised loads; ``results``, ``runs``: a model's results,
    and the runs of the 3D reference, for both. The rigidity is the change of the axial load over that of the displacement.
    """
    place = max(assembly.loads, key=lambda load: abs(load.force[2])).at
    forces = [sum(load.force[2] for load in one.loads) for one in (assembly, raised)]
    by_model = [float(np.interp(place, r.centreline_z, r.centreline[:, 2])) for r in results]
    by_run = [float(np.interp(place, r.centreline[:, 0], r.centreline[:, 3])) for r in runs]
    return _axial_errors(*([*zip(moved, forces, strict=True)] for moved in (by_model, by_run)))


def error_percent_or_none(value: float | None, reference: float | None) -> float | None:
    """Return the error of ``value`` [% of ``reference``]; None if one of them is None, or if ``reference`` is zero."""
    return None if value is None or not reference else round(float(error_percent(value, reference)), 4)
