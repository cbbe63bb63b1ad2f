"""Mesh levels of the 3D reference and of rolling contacts, and variants of the 3D reference.

Each level refines all settings of the previous one. Each variant changes one modelling or numerical choice. Mesh settings
are varied on the finest level, all other choices on the coarsest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from rollbench.compare import files
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import Dimensions, dimensions_of_3d_parts, largest_groove_depths

#: Ball radius [m] for which the lengths in the settings are stated; for other radii they are scaled in proportion.
BALL = 2.778e-3
_TABLES = files.read_shipped_toml("reference/levels.toml")


def _settings_from_toml(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the mesh settings of a TOML table with lists converted to tuples."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in keys.items()}


#: Mesh settings (`hifi.meshing.settings.Settings`) of each level, coarse to fine; lengths in m. b_over_h counts
#: second-order cells, so that there are twice as many nodes. From one level to the next, the cells at the contact are
#: refined by 4/3. The following are refined by 1.15 to 1.2: cells and refinement boxes of the submodels for a contact's
#: local compliance, coarse bodies and balls, which only transfer loads between contacts, and the models of the shaft's cut
#: ends. The growth of the patches' cells and the numbers of modes follow. The plane mesh of the shaft's cross-section is
#: the same on all levels; its error is below 0.04 % in bending (tests/unit/hifi/test_helical_section.py).
LEVELS: dict[int, dict[str, Any]] = {int(level): _settings_from_toml(keys) for level, keys in _TABLES["level"].items()}
#: Finer values of single mesh settings, with which some of the `VARIANTS` refine the level `PRODUCTION`.
BEYOND: dict[str, Any] = _settings_from_toml(_TABLES["beyond"])
#: Level 0 is the mesh of Lin's thesis: first-order tetrahedra, 0.08 mm around every contact, 5 mm elsewhere (made of split
#: second-order ones of twice the size). It is not part of a convergence study.
SOURCE_LEVEL = 0
#: Mesh settings of level 0, the mesh of Lin's thesis.
SOURCE_MESH: dict[str, Any] = _settings_from_toml(_TABLES["source"])
#: Finest mesh level of ordinary use; some variants refine single settings of it.
PRODUCTION = 3
#: Levels of a mesh study. The last one is finer than `PRODUCTION` and tests the uncertainty estimated from the others. For
#: scenes with lightly loaded contacts next to heavily loaded ones, level 5 tests the uncertainty from levels 1 to 4.
STUDIED = (1, 2, 3, 4)
#: Default levels of a scene outside the studies: level 3 is more accurate than level 1 by a factor of 1.8, measured on all
#: scenes that were solved on three levels or more. Between consecutive levels the factors are 1.6, 1.2 and 1.2, because the
#: error due to the mesh of the refinement boxes (blocks below the contacts) is the same on all levels
#: (tests/unit/models/test_grid_coverage.py).
ADVISED = (1, 3)
#: Kinds of bodies in models of rolling contacts.
HALF_SPACE, FINITE = "half-space", "finite"
_RATIOS = ("b_over_h", "growth")


def mesh_settings_of_level(level: int, ball_radius: float, refined_settings: Sequence[str] = ()) -> dict[str, Any]:
    """Return the mesh settings of a mesh level by name, with all lengths scaled in proportion to the ball radius.

    ``ball_radius``: ball radius [m]; ``refined_settings``: names of settings whose values are replaced by the finer ones in
    `BEYOND`.
    """
    ratio, regular = ball_radius / BALL, SOURCE_MESH if level == SOURCE_LEVEL else LEVELS[level]
    settings = regular | {name: BEYOND[name] for name in refined_settings}

    def scaled_to_ball_radius(name: str, value: Any) -> Any:
        if isinstance(value, float) and name not in _RATIOS:
            return value * ratio
        return tuple(x * ratio for x in value) if name.endswith("sizes") else value

    return {name: scaled_to_ball_radius(name, value) for name, value in settings.items()}


#: Function that returns a changed copy of a scene.
Change = Callable[[Scene], Scene]
#: Kind of a choice. "modelling": an idealisation, or a dimension that Lin's thesis does not state; "numerical": a choice of
#: method or mesh; "scene": another boundary condition, which the scene must state.
Kind = Literal["modelling", "numerical", "scene"]
#: Bound on the axial-torsional coupling of a grooved shaft: its twist by an axial force over the geometric mean of axial
#: and torsional compliance (`hifi.shaft.section.EquivalentBeam.axial_torsional_coupling`,
#: tests/unit/hifi/test_helical_section.py) [1]. The beams that continue the 3D part of the shaft neglect this coupling.
COUPLING = 0.02


@dataclass(frozen=True)
class ReferenceVariant:
    """Variant of the 3D reference in which one modelling or numerical choice is changed, to measure its effect."""

    #: Description of the change.
    label: str
    #: Name of the choice that is changed; of several variants of one choice, the largest effect counts.
    choice: str
    #: Kind of the choice: "modelling", "numerical" or "scene".
    kind: Kind
    #: Function that returns the changed scene.
    change: Change
    #: Names of those mesh settings of the finest level (`PRODUCTION`) that the variant replaces by the finer values in
    #: `BEYOND`; empty: the variant does not refine the mesh.
    refined: tuple[str, ...] = ()

    @property
    def level(self) -> int:
        """Mesh level on which the variant is computed."""
        return PRODUCTION if self.refined else min(LEVELS)


def unchanged_scene(scene: Scene) -> Scene:
    """Return the scene unchanged; used as ``change`` of those variants that differ from the reference only in the mesh."""
    return scene


def change_solid_model(**changes: Any) -> Change:
    """Return a function that copies a scene with changed entries of ``scene.solid``, which only the 3D model uses.

    ``changes``: new values by name of the field.
    """
    return lambda scene: replace(scene, solid=replace(scene.solid, **changes))


def scale_dimension(name: str, dimension_of: Callable[[Dimensions], float], factor: float, shift: float = 0.0) -> Change:
    """Return a function that copies a scene with one dimension of the 3D model changed.

    ``name``: field of ``scene.solid``; ``dimension_of``: function that returns the present dimension [m], which is
    multiplied by ``factor`` and increased by ``shift`` [m].
    """
    return lambda scene: change_solid_model(**{name: dimension_of(dimensions_of_3d_parts(scene)) * factor + shift})(scene)


def lengthen_3d_shaft(leads: float) -> Change:
    """Return a function that copies a scene with a longer 3D part of its shaft; ``leads``: length added, in leads."""
    return lambda scene: scale_dimension("shaft", lambda d: d.shaft, 1.0, leads * abs(scene.track.lead))(scene)


def fix_half_of_face(half: Literal["inner", "outer"]) -> Change:
    """Return a function that copies a scene with the nut fixed only at the inner or outer half of its fixed face.

    ``half``: which half of the face's width. For a flanged nut it is the half of the flange's seat. The function raises
    ValueError if the nut is not fixed at one face.
    """

    def scene_with_half_of_face_fixed(scene: Scene) -> Scene:
        face, flange = dimensions_of_3d_parts(scene).nut_held, scene.nut.flange
        if flange is not None and face.startswith("flange"):
            low, high = flange.seat
            seat = (low, 0.5 * (low + high)) if half == "inner" else (0.5 * (low + high), high)
            return replace(scene, nut=replace(scene.nut, flange=replace(flange, seat=seat)))
        if face not in ("left face", "right face"):
            needed = "half of the nut's end face can be fixed only if the nut is fixed at one end face"
            raise ValueError(f"{needed}; this nut is fixed at: {face}")
        return change_solid_model(nut_held=f"{face}, {half} half")(scene)

    return scene_with_half_of_face_fixed


def with_plain_shaft(scene: Scene) -> Scene:
    """Return a copy of the scene whose shaft outside the 3D mesh is a cylinder without groove, of the land diameter."""
    return change_solid_model(shaft_diameter=scene.screw.outer_diameter)(scene)


def with_shortened_groove(scene: Scene) -> Scene:
    """Return a copy of the scene whose shaft is meshed in 3D over half the length only, and has no groove outside."""
    return with_plain_shaft(scale_dimension("shaft", lambda d: d.shaft, 0.5)(scene))


def with_supports_turned_by_coupling(scene: Scene) -> Scene:
    """Return a copy of the scene with supports rotated by the twist due to the shaft's axial-torsional coupling.

    The 3D reference neglects this coupling outside the 3D part of the shaft. Between a support and the nut at the distance
    L, the shaft would twist by |c| F L / sqrt(EA GJ), with the coupling c (`COUPLING`) and the sum F of the axial loads.
    The stiffnesses EA and GJ are those of a shaft without groove whose radius is the pitch radius less the groove radius;
    this shaft twists more than the grooved one. If the bore reaches that radius, the radius of the bottom of the groove is
    taken instead.
    """
    e = scene.screw.material
    core = scene.track.pitch_radius - scene.screw.groove_radius
    if core <= scene.screw.bore / 2.0:
        core = scene.track.pitch_radius - largest_groove_depths(scene)[0]
    area = np.pi * (core**2 - (scene.screw.bore / 2.0) ** 2)
    polar = 0.5 * np.pi * (core**4 - (scene.screw.bore / 2.0) ** 4)
    force = sum(abs(load.force[2]) for load in scene.loads)
    rate = COUPLING * force / float(np.sqrt(e.youngs_modulus * area * e.shear_modulus * polar))

    def freedom_with_added_twist(freedom: tuple[str, float], at: float) -> tuple[str, float]:
        return (freedom[0], freedom[1] + rate * abs(at - scene.nut.position)) if freedom[0] == "rz" else freedom

    supports = tuple(replace(s, fixed=tuple(freedom_with_added_twist(f, s.at) for f in s.fixed)) for s in scene.supports)
    return replace(scene, supports=supports)


#: Names of the choices that `VARIANTS` change.
LANDS, HOLE, WIDTH = "radius of the nut's lands", "hole along the meshed screw", "width of the nut's held face"
LENGTH, PHASE = "length of the shaft meshed in 3D", "azimuth along the helix at which the 3D shaft ends"
FILLED = "where the nut's groove ends"
GROOVE_END, TWIST = "where the screw's groove ends", "axial-torsional coupling of the shaft outside the 3D mesh"
SHARED, MODES, FIXING = "meshes shared with other scenes", "deformation modes per contact patch", "where the nut is held"


def mesh_refinement_variant(label: str, choice: str, *refined: str) -> ReferenceVariant:
    """Create a variant of the 3D reference with finer values of the mesh settings named ``refined`` on level `PRODUCTION`.

    ``label``: description of the variant; ``choice``: numerical choice that it varies.
    """
    return ReferenceVariant(label, choice, "numerical", unchanged_scene, refined)


_shaft = partial(scale_dimension, "shaft", lambda d: d.shaft)
_land = partial(scale_dimension, "nut_inner_diameter", lambda d: 2.0 * d.land)
_hole = scale_dimension("hole_diameter", lambda d: 2.0 * d.hole, 0.5)
_width = "nut fixed at the {} half of its face's width"
_filled = "nut's groove ends two ball diameters beyond the outermost balls"
_alone = "meshes for this scene alone: only its loaded flanks refined, contact grid for its own loads"

#: Variants of the 3D reference, by their names in the names of stored runs.
VARIANTS: dict[str, ReferenceVariant] = {
    "base": ReferenceVariant(_alone, SHARED, "numerical", unchanged_scene),
    "junction": ReferenceVariant(
        "shaft meshed in 3D over 20 mm more on each side", LENGTH, "modelling", _shaft(1.0, 20e-3)
    ),
    "junction-short": ReferenceVariant("shaft meshed in 3D over half the length", LENGTH, "modelling", _shaft(0.5)),
    "junction-phase": ReferenceVariant(
        "shaft meshed in 3D over half a lead more on each side", PHASE, "modelling", lengthen_3d_shaft(0.5)
    ),
    "land": ReferenceVariant("diameter of the nut's lands 0.6 mm smaller", LANDS, "modelling", _land(1.0, -0.6e-3)),
    "land-wide": ReferenceVariant("diameter of the nut's lands 0.6 mm larger", LANDS, "modelling", _land(1.0, 0.6e-3)),
    "hole": ReferenceVariant("hole along the screw with half the diameter", HOLE, "modelling", _hole),
    "held-outer": ReferenceVariant(_width.format("outer"), WIDTH, "modelling", fix_half_of_face("outer")),
    "held-inner": ReferenceVariant(_width.format("inner"), WIDTH, "modelling", fix_half_of_face("inner")),
    "nut-filled": ReferenceVariant(_filled, FILLED, "modelling", change_solid_model(nut_groove="loaded")),
    "shaft-plain": ReferenceVariant(
        "shaft outside the 3D mesh plain, with the diameter of the lands", GROOVE_END, "scene", with_plain_shaft
    ),
    "runout": ReferenceVariant(
        "shaft meshed in 3D over half the length, and without groove beyond", GROOVE_END, "scene", with_shortened_groove
    ),
    "finer-contact": mesh_refinement_variant(
        "4.2 instead of 3.2 cells per semi-axis of the contact ellipse", "cells at the contact", "b_over_h"
    ),
    "finer-patch": mesh_refinement_variant(
        "growth of the cells of contact patches 1.5 instead of 1.62", "cells of the contact patches", "growth"
    ),
    "finer-own": mesh_refinement_variant(
        "finer refinement boxes and cells in the submodels of one contact",
        "submodels of one contact",
        "own_cuts",
        "own_sizes",
        "own_ball_sizes",
    ),
    "finer-bodies": mesh_refinement_variant("finer cells of screw and nut", "cells of screw and nut", "fine", "coarse"),
    "finer-sockets": mesh_refinement_variant(
        "edges of the refinement boxes divided into 4 x 3 x 4 instead of 3 x 2 x 3 parts",
        "mesh of the refinement boxes",
        "cuts",
    ),
    "modes": mesh_refinement_variant("28 instead of 14 deformation modes per contact patch", MODES, "modes"),
    "finer-ball": mesh_refinement_variant(
        "finer cells and more modes of the ball", "cells and modes of the ball", "ball_fine", "ball_coarse", "ball_modes"
    ),
    "finer-cell": mesh_refinement_variant("finer cells of the shaft's cut ends", "cells of the shaft's cut ends", "cell"),
    "nut-right": ReferenceVariant(
        "nut fixed at its right face", FIXING, "scene", change_solid_model(nut_held="right face")
    ),
    "nut-outer": ReferenceVariant(
        "nut fixed at its outer surface", FIXING, "scene", change_solid_model(nut_held="outer surface")
    ),
}

#: Choices that the modelling uncertainty does not include.
NOT_VARIED = {
    "deflectors and return tubes of the nut": (
        "between loaded turns the groove runs on; what fills it there or pierces the wall is not meshed, nor are wipers "
        "and their counterbores"
    ),
    "chamfers and run-in of the lands": "edges of lands and faces are sharp",
    "stiffness of what holds the nut and the screw": "held nodes do not move; a housing would",
    "friction, large strains, contact of the second order in ball over groove radius": "left out of the model",
}
