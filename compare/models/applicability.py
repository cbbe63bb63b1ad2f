"""Check whether a scene's dimensions lie within the range of the scenes that were compared with the 3D reference.

A scene is described by numbers (descriptors) such as lead over pitch diameter, which are known before it is solved. The
scene is outside the range if a descriptor exceeds the range of the compared scenes by more than its margin.
`compare.models.model_form` does the same with numbers that depend on the loads (preload, spread, lateral force and moment).
If a scene is outside the range in a number of either kind, its expected error is "not covered".
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.scenes import catalogue
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions_of_3d_parts


@dataclass(frozen=True)
class Descriptor:
    """Number that describes a scene, with the margin by which it may exceed the range of the compared scenes.

    Compared scenes are those whose results by low-order models were compared with the 3D reference.
    """

    #: Name of the descriptor.
    name: str
    #: Unit of the descriptor's value and margin; empty without unit.
    unit: str
    #: Distance by which the value of a scene may lie outside the range of the compared scenes if the scene is still to
    #: count as similar to them [unit].
    margin: float
    #: Function that computes the descriptor's value for a scene [unit].
    value_of_scene: Callable[[Scene], float]


def _lateral_misalignment_of_supports(scene: Scene) -> float:
    """Return the misalignment of the supports: largest difference of their prescribed lateral displacements [um]."""
    given = {axis: [0.0, *(v for s in scene.supports for k, v in s.fixed if k == axis)] for axis in ("ux", "uy")}
    across, up = (max(v) - min(v) for v in given.values())
    return 1e6 * float(np.hypot(across, up))


def _ball_oversize_over_diameter(scene: Scene) -> float:
    """Return the oversize of the ball radius over the ball diameter, which measures the preload of a scene [1e-3]."""
    return 1e3 * scene.errors.balls.oversize / (2.0 * scene.balls.radius)


def _nut_overhang_in_ball_radii(scene: Scene) -> float:
    """Return the distance from the outermost ball centre to the nearer face of the nut, over the ball radius.

    Ratios above 4 are returned as 4.

    Near the face only a thin lip supports the flank (`lowfi.compliance.faces`), and few such scenes were compared.
    """
    z, half = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0
    return min(float(half - np.abs(z).max()) / scene.balls.radius, 4.0)


def _shaft_span_over_diameter(scene: Scene) -> float:
    """Return the length of shaft between the outermost supports, loads and nut faces, over the shaft's diameter.

    Ratios below 12, the least that were drawn, are returned as 12: a shorter shaft bends less.
    """
    half = scene.nut.length / 2.0
    acting = [*(x.at for x in scene.supports), *(x.at for x in scene.loads)]
    places = [scene.nut.position - half, scene.nut.position + half, *acting]
    return max((max(places) - min(places)) / scene.screw.outer_diameter, 12.0)


def _poissons_ratio_farthest_from_steel(scene: Scene) -> float:
    """Return, of the Poisson's ratios of screw, nut and balls, the one that differs most from 0.3, the value of steel."""
    ratios = (scene.screw.material, scene.nut.material, scene.balls.material)
    return max((m.poissons_ratio for m in ratios), key=lambda ratio: abs(ratio - 0.3))


#: Descriptors of a scene. The margins are assumptions of the order of the steps between the compared scenes. Young's moduli
#: have no such step, because all parts of the compared scenes are of one steel. The nut's compliance causes most of the
#: error of the model lin; this error grows by a quarter if the nut's modulus changes by its margin. The balls' modulus
#: changes only the Hertz constants, so its margin includes silicon nitride.
DESCRIPTORS = (
    Descriptor("length of the nut over the pitch diameter", "", 0.8, lambda s: s.nut.length / (2.0 * s.track.pitch_radius)),
    Descriptor(
        "wall of the nut over the pitch radius",
        "",
        0.1,
        lambda s: (s.nut.outer_diameter / 2.0 - dimensions_of_3d_parts(s).land) / s.track.pitch_radius,
    ),
    Descriptor("lead over the pitch diameter", "", 0.25, lambda s: s.track.lead / (2.0 * s.track.pitch_radius)),
    Descriptor("ball over the pitch diameter", "", 0.06, lambda s: s.balls.radius / s.track.pitch_radius),
    Descriptor("number of balls", "", 60.0, lambda s: float(s.ball_count)),
    Descriptor("oversize over the ball's diameter", "1e-3", 1.0, _ball_oversize_over_diameter),
    Descriptor(
        "conformity, the tighter groove",
        "",
        0.02,
        lambda s: min(s.screw.groove_radius, s.nut.groove_radius) / (2.0 * s.balls.radius),
    ),
    Descriptor("span of the shaft over its diameter", "", 3.0, _shaft_span_over_diameter),
    Descriptor("misalignment of the supports", "um", 300.0, _lateral_misalignment_of_supports),
    Descriptor("nut beyond the last balls over the ball's radius", "", 0.5, _nut_overhang_in_ball_radii),
    Descriptor(
        "Young's modulus of the nut over the screw's",
        "",
        0.2,
        lambda s: s.nut.material.youngs_modulus / s.screw.material.youngs_modulus,
    ),
    Descriptor(
        "Young's modulus of the balls over the screw's",
        "",
        0.5,
        lambda s: s.balls.material.youngs_modulus / s.screw.material.youngs_modulus,
    ),
    Descriptor("Poisson's ratio, the one farthest from 0.3", "", 0.05, _poissons_ratio_farthest_from_steel),
)


@dataclass(frozen=True)
class DescriptorWithRange:
    """Value of one descriptor of a scene (such as lead over pitch diameter), and its range over the compared scenes.

    Compared scenes are those whose results were compared with the 3D reference.
    """

    #: The descriptor.
    descriptor: Descriptor
    #: Value of the descriptor in the scene.
    value: float
    #: Smallest value of the descriptor in the compared scenes.
    low: float
    #: Largest value of the descriptor in the compared scenes.
    high: float

    @property
    def outside(self) -> bool:
        """Whether the scene's value lies outside the range of the compared scenes by more than the descriptor's margin."""
        d = self.descriptor.margin * (1.0 + 1e-9)
        return not self.low - d <= self.value <= self.high + d

    @property
    def range_sentence(self) -> str:
        """Sentence that states the scene's value of the descriptor and the range of the compared scenes."""
        unit = f" {self.descriptor.unit}" if self.descriptor.unit else ""
        compared = f"{self.low:.4g} to {self.high:.4g}{unit}"
        return f"{self.descriptor.name} is {self.value:.4g}{unit}, that of compared scenes is {compared}"


@cache
def compared_scenes(*, of_bearings: bool) -> tuple[Scene, ...]:
    """Return the built-in scenes that were compared with the 3D reference: bearings if ``of_bearings``, else screws."""
    names = (*catalogue.names_of_scenes_with_role("referenced"), *catalogue.names_of_scenes_with_role("unseen"))
    scenes = (catalogue.scene(name) for name in names)
    return tuple(s for s in scenes if (s.track.lead == 0.0) == of_bearings)


#: File with the random screws that were compared (by `rollbench stability`), in a folder of 3D reference runs.
SURVEY = "survey.json"

#: File with the double nuts that were compared (by `rollbench stability --kind double-nut`), in the same folder.
DOUBLE_NUT_SURVEY = "double-nuts.json"

#: File with the random screws that were drawn and compared once, after the last change of the models, in the same folder.
#: They calibrate nothing.
NEW_SURVEY = "new-screws.json"

#: Numbers of the random screws that calibrate expected errors, and from which no error is fitted: the second half of the
#: nuts without a flange, and sixty with a flange that were drawn after the errors were fitted.
CALIBRATING = (*range(100, 200), *range(240, 300))


@cache
def survey_records_of_random_screws(file: str = SURVEY) -> tuple[dict[str, Any], ...]:
    """Read the errors of models against the 3D reference on the randomly drawn screws or double nuts, as JSON.

    ``file``: name of the file with the records.

    The tuple is empty if the file with the records cannot be used.
    """
    try:
        scenes = json.loads(files.shipped_text(f"references/{file}"))["scenes"]
        return tuple(row for row in scenes if row.get("points"))
    except (OSError, ValueError, TypeError, KeyError):
        return ()


@cache
def descriptors_of_random_screws() -> tuple[dict[str, float], ...]:
    """Return the values of all descriptors, by name, for each of the randomly drawn screws."""
    return tuple({d.name: float(row["places"][d.name]) for d in DESCRIPTORS} for row in survey_records_of_random_screws())


#: File with the descriptors of the compared built-in scenes, stored because reading all scenes would take longer.
PLACES = "places.json"


def save_descriptors_of_built_in_scenes(folder: Path) -> None:
    """Write the descriptors of all compared built-in screws and bearings to the file `PLACES` in the folder ``folder``.

    The folder holds runs of the 3D reference.
    """
    by_kind = {
        kind: {s.name: {d.name: d.value_of_scene(s) for d in DESCRIPTORS} for s in compared_scenes(of_bearings=bearings)}
        for kind, bearings in (("rings", True), ("screws", False))
    }
    files.replace_file(folder / PLACES, json.dumps(by_kind, indent=1) + "\n")


@cache
def descriptors_of_built_in_scenes(*, of_bearings: bool) -> tuple[dict[str, float], ...]:
    """Read the stored descriptor values of each compared built-in bearing if ``of_bearings``, else of each compared screw.

    Empty if the file `PLACES` is missing or damaged.
    """
    try:
        rows = json.loads(files.shipped_text(f"references/{PLACES}"))["rings" if of_bearings else "screws"].values()
        return tuple({d.name: float(place[d.name]) for d in DESCRIPTORS} for place in rows)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return ()


def descriptor_values_of_compared_scenes(descriptor: Descriptor, *, of_bearings: bool) -> list[float]:
    """Return a descriptor's values for all bearings (if ``of_bearings``) or screws compared with the 3D reference.

    A descriptor is a number that characterises a scene, such as its contact angle.
    """
    random = () if of_bearings else descriptors_of_random_screws()
    return [scene[descriptor.name] for scene in (*descriptors_of_built_in_scenes(of_bearings=of_bearings), *random)]


def descriptors_with_ranges(scene: Scene) -> tuple[DescriptorWithRange, ...]:
    """Return each descriptor of a scene with its range over the compared scenes of the same kind (screws or bearings).

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.

    Returns
    -------
    tuple of DescriptorWithRange
        Value and range of each descriptor; empty if no scene of its kind was compared.

    Raises
    ------
    ValueError
        If no dimensions of the 3D parts follow from the scene (`meshes.solid.dimensions_of_3d_parts`).
    """
    ring = scene.track.lead == 0.0
    ranges = [(d, descriptor_values_of_compared_scenes(d, of_bearings=ring)) for d in DESCRIPTORS]
    return tuple(DescriptorWithRange(d, d.value_of_scene(scene), min(v), max(v)) for d, v in ranges if v)


def descriptors_outside_range(scene: Scene) -> tuple[str, ...]:
    """Return a sentence for each descriptor whose value in the scene lies outside the range of the compared scenes.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.

    Returns
    -------
    tuple of str
        Sentences with the scene's value and the compared range; one sentence that says so if the data of the compared
        scenes are missing.

    Raises
    ------
    ValueError
        If no dimensions of the 3D parts follow from the scene (`meshes.solid.dimensions_of_3d_parts`).
    """
    if not descriptors_of_built_in_scenes(of_bearings=scene.track.lead == 0.0):
        return (f"the range of the compared scenes is not known, because references/{PLACES} is missing or damaged",)
    return tuple(place.range_sentence for place in descriptors_with_ranges(scene) if place.outside)
