"""Whether a scene lies within the range of the scenes compared with the 3D reference, by descriptors of its parts.

Descriptors need no solution, so a scene can be placed before it is solved. A scene is outside if a descriptor is beyond the
compared range by more than its margin. `compare.models.model_form` adds features of the loads (preload, spread, lateral
force and moment); outside in either, the error to expect is "not covered".
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.scenes import catalogue
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import solid_dimensions


@dataclass(frozen=True)
class Descriptor:
    """Number that describes a scene, with the margin by which it may exceed the compared range."""

    #: Name of the descriptor.
    name: str
    #: Unit of value and margin.
    unit: str
    #: Distance beyond the compared range that still counts as similar [unit].
    margin: float
    #: Function that computes the value of a scene [unit].
    value: Callable[[Scene], float]


def _largest_lateral_displacement(scene: Scene) -> float:
    """Return the largest lateral displacement prescribed between supports [um]."""
    given = {axis: [0.0, *(v for s in scene.supports for k, v in s.fixed if k == axis)] for axis in ("ux", "uy")}
    across, up = (max(v) - min(v) for v in given.values())
    return 1e6 * float(np.hypot(across, up))


def _preload(scene: Scene) -> float:
    """Return the oversize of the balls over their diameter [1e-3]."""
    return 1e3 * scene.errors.balls.oversize / (2.0 * scene.balls.radius)


def _nut_length_beyond_balls(scene: Scene) -> float:
    """Return the smallest length of nut or outer ring beyond the outermost ball centres, over the ball radius; at most 4.

    Where balls run up to the face, only a thin lip supports their flanks (`lowfi.compliance.faces`); few such scenes were
    compared.
    """
    z, half = ball_layout(scene).z - scene.nut.position, scene.nut.length / 2.0
    return min(float(half - np.abs(z).max()) / scene.balls.radius, 4.0)


def _poisson(scene: Scene) -> float:
    """Return the Poisson's ratio, among all parts, that differs most from 0.3 (steel)."""
    ratios = (scene.screw.material, scene.nut.material, scene.balls.material)
    return max((m.poissons_ratio for m in ratios), key=lambda ratio: abs(ratio - 0.3))


#: Descriptors of a scene. Margins are of the order of the steps between the compared scenes: a choice, not a result.
#: Young's moduli have no such step, as all parts of the compared scenes are of one steel. The nut's compliance causes
#: most of lin's error, which grows by a quarter at the margin of the nut's modulus. The modulus of the balls changes
#: only Hertz constants: its margin includes silicon nitride.
DESCRIPTORS = (
    Descriptor("length of the nut over the pitch diameter", "", 0.8, lambda s: s.nut.length / (2.0 * s.track.pitch_radius)),
    Descriptor(
        "wall of the nut over the pitch radius",
        "",
        0.1,
        lambda s: (s.nut.outer_diameter / 2.0 - solid_dimensions(s).land) / s.track.pitch_radius,
    ),
    Descriptor("lead over the pitch diameter", "", 0.25, lambda s: s.track.lead / (2.0 * s.track.pitch_radius)),
    Descriptor("ball over the pitch diameter", "", 0.06, lambda s: s.balls.radius / s.track.pitch_radius),
    Descriptor("number of balls", "", 60.0, lambda s: float(s.ball_count)),
    Descriptor("oversize over the ball's diameter", "1e-3", 1.0, _preload),
    Descriptor(
        "conformity, the tighter groove",
        "",
        0.02,
        lambda s: min(s.screw.groove_radius, s.nut.groove_radius) / (2.0 * s.balls.radius),
    ),
    Descriptor("misalignment of the supports", "um", 300.0, _largest_lateral_displacement),
    Descriptor("nut beyond the last balls over the ball's radius", "", 0.5, _nut_length_beyond_balls),
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
    Descriptor("Poisson's ratio, the one farthest from 0.3", "", 0.05, _poisson),
)


@dataclass(frozen=True)
class DescriptorInRange:
    """Value of one descriptor of a scene, and the range of the compared scenes."""

    #: The descriptor.
    descriptor: Descriptor
    #: Value of the scene.
    value: float
    #: Smallest value of the compared scenes.
    low: float
    #: Largest value of the compared scenes.
    high: float

    @property
    def outside(self) -> bool:
        """Whether the value is beyond the compared range by more than the margin."""
        d = self.descriptor.margin * (1.0 + 1e-9)
        return not self.low - d <= self.value <= self.high + d

    @property
    def text(self) -> str:
        """Sentence with the scene's value and the compared range."""
        unit = f" {self.descriptor.unit}" if self.descriptor.unit else ""
        return f"{self.descriptor.name} is {self.value:.4g}{unit}, compared were {self.low:.4g} to {self.high:.4g}{unit}"


@cache
def compared_scenes(*, ring: bool) -> tuple[Scene, ...]:
    """Return the shipped scenes that were compared with the 3D reference: rings if ``ring``, else screws."""
    names = (*catalogue.names_with_role("referenced"), *catalogue.names_with_role("unseen"))
    scenes = (catalogue.scene(name) for name in names)
    return tuple(s for s in scenes if (s.track.lead == 0.0) == ring)


#: Record of drawn screws that were compared (the survey of `rollbench stability`), in a store of runs.
SURVEY = "survey.json"

#: Number of the first drawn screws, whose errors are known to the expected error; the screws after them judge it.
KNOWN_SCREWS = 240


@cache
def survey_records() -> tuple[dict[str, Any], ...]:
    """Return the survey's records of the first `KNOWN_SCREWS` drawn screws; empty if its file cannot be used."""
    try:
        scenes = json.loads(files.text(f"references/{SURVEY}"))["scenes"]
        return tuple(row for row in scenes if row["number"] < KNOWN_SCREWS and row.get("points"))
    except (OSError, ValueError, TypeError, KeyError):
        return ()


@cache
def descriptors_of_drawn_screws() -> tuple[dict[str, float], ...]:
    """Return, for each of the first `KNOWN_SCREWS` drawn screws, its descriptors by name."""
    return tuple({d.name: float(row["places"][d.name]) for d in DESCRIPTORS} for row in survey_records())


#: File with the descriptors of the compared shipped scenes, in a store of runs: reading all scenes would be slower.
PLACES = "places.json"


def save_descriptors(store: Path) -> None:
    """Write the descriptors of all compared shipped screws and rings to `PLACES` in a store."""
    from rollbench.compare.files import replace_file

    by_kind = {
        kind: {s.name: {d.name: d.value(s) for d in DESCRIPTORS} for s in compared_scenes(ring=kind == "rings")}
        for kind in ("rings", "screws")
    }
    replace_file(store / PLACES, json.dumps(by_kind, indent=1) + "\n")


@cache
def descriptors_of_shipped_scenes(*, ring: bool) -> tuple[dict[str, float], ...]:
    """Return the descriptors of each compared shipped ring, or screw; empty if `PLACES` is missing or damaged."""
    try:
        rows = json.loads(files.text(f"references/{PLACES}"))["rings" if ring else "screws"].values()
        return tuple({d.name: float(place[d.name]) for d in DESCRIPTORS} for place in rows)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return ()


def compared_values(descriptor: Descriptor, *, ring: bool) -> list[float]:
    """Return a descriptor's values for all compared rings if ``ring``, else for all screws, shipped and drawn."""
    return [
        place[descriptor.name]
        for place in (*descriptors_of_shipped_scenes(ring=ring), *(() if ring else descriptors_of_drawn_screws()))
    ]


def descriptors_in_range(scene: Scene, among: Sequence[Scene] | None = None) -> tuple[DescriptorInRange, ...]:
    """Compare the descriptors of a scene with those of the compared scenes of its kind (screws or rings).

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    among
        Compared scenes; None: all shipped and drawn ones.

    Returns
    -------
    tuple of Place
        One for each descriptor; empty if no scene of its kind was compared.

    Raises
    ------
    ValueError
        If the scene has no solid dimensions (`meshes.solid.solid_dimensions`).
    """
    ring = scene.track.lead == 0.0
    out = []
    for d in DESCRIPTORS:
        values = compared_values(d, ring=ring) if among is None else [d.value(s) for s in among]
        if values:
            out.append(DescriptorInRange(d, d.value(scene), min(values), max(values)))
    return tuple(out)


def outside(scene: Scene) -> tuple[str, ...]:
    """Describe each descriptor of a scene that is outside the compared range.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.

    Returns
    -------
    tuple of str
        A sentence for each; a single sentence to that effect if the data of the compared scenes are missing.

    Raises
    ------
    ValueError
        If the scene has no solid dimensions (`meshes.solid.solid_dimensions`).
    """
    if not descriptors_of_shipped_scenes(ring=scene.track.lead == 0.0):
        return (f"what was compared is not known, because references/{PLACES} is absent or damaged: reinstall rollbench",)
    return tuple(place.text for place in descriptors_in_range(scene) if place.outside)
