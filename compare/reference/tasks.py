"""Tasks of the 3D reference: load cases that share meshes, flanks that must be meshed, and mesh settings of a level.

The meshed and condensed parts of a nut or bearing row are a set-up. Equal rows on one shaft share a set-up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.reference.levels import LEVELS, SOURCE_LEVEL, VARIANTS, mesh_settings_of_level
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene
from rollbench.meshes.record_keys import RecordFields, canonical_text

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import ExpectedContacts, Settings

#: Scenes that the 3D reference solves: one nut or bearing row, or several on one shaft.
Solvable = Scene | Assembly
#: Names of the settings in which a stored mesh may differ from the required one: contact cells may be finer, patches
#: larger, and more flanks meshed.
_SIZED = ("semi", "reach", "sides")


@dataclass(frozen=True)
class MeshSpecification:
    """Bodies, groove flanks and settings of the 3D mesh of a nut or bearing row; equal rows on a shaft share one record."""

    #: Nut or row as a scene; on a shaft with several, axial positions are relative to this one.
    parts: Scene
    #: Numbers of the meshed flanks: 0 to 3 for SL, SR, NL, NR.
    meshed_flanks: tuple[int, ...]
    #: Sizes of cells and contact patches, and further settings of the mesh.
    mesh_settings: Settings
    #: Numbers (from 0) of those nuts or rows on the shaft that are equal and share this mesh.
    set_numbers: tuple[int, ...] = (0,)


def stations_of_load_cases(*cases: Solvable) -> tuple[float, ...]:
    """Return the axial positions [m] of supports and loads of all load cases, at which the 3D shaft has nodes."""
    return tuple(sorted({x.at for case in cases for given in (case.supports, case.loads) for x in given}))


def ball_slices_by_set(described: Solvable) -> list[slice]:
    """Return, for each nut or ball bearing on a shaft, the index range of its balls in the list of all balls."""
    sets = [described] if isinstance(described, Scene) else [s.parts for s in described.sets if isinstance(s.parts, Scene)]
    ends = np.cumsum([0, *(scene.ball_count for scene in sets)])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def not_covered_by_3d_reference_error(described: Solvable, error: ValueError) -> SceneNotCoveredError:
    """Return the error to raise for a scene that the 3D reference cannot solve.

    ``described``: the scene; ``error``: error whose message states the reason.
    """
    advice = "change the named dimension or key, or use a low-order model"
    return SceneNotCoveredError(described.name, "3D reference", str(error), advice)


def _bodies_to_mesh(case: Solvable) -> list[Scene]:
    """Return each nut or bearing row of a load case as a scene to be meshed.

    SceneNotCoveredError if the 3D reference cannot model the shaft of ``case``, for example because of rollers.
    """
    if isinstance(case, Scene):
        return [case]
    from rollbench.hifi.several_sets import meshed_geometry_of_each_set

    try:
        return [of_set.parts_without_errors for of_set in meshed_geometry_of_each_set(case)]
    except ValueError as error:
        raise not_covered_by_3d_reference_error(case, error) from error


def _estimate_expected_contacts(case: Solvable, bodies: Sequence[Scene]) -> tuple[ExpectedContacts, ...]:
    """Return the expected contact loads and angles of each nut or bearing, from which mesh sizes are chosen.

    ``case``: load case; ``bodies``: nut or bearing rows to be meshed, as scenes. For a nut or bearing without load, a tenth
    of the mean load of all loaded contacts on the shaft is assumed. SceneNotCoveredError if the loads cannot be estimated.
    """
    from rollbench.hifi.meshing import settings

    try:
        if isinstance(case, Scene):
            return (settings.estimate_contacts_of_scene(case),)
        expected = settings.estimate_contacts_of_each_set(case)
        carried = np.concatenate([e.loads[e.loads > 0.0] for e in expected])
        light = 0.1 * float(carried.mean()) if carried.size else 0.0
        return tuple(
            e if e.loads.any() else settings.estimate_contacts_under_assumed_load(body, e, light)
            for body, e in zip(bodies, expected, strict=True)
        )
    except ValueError as error:
        raise not_covered_by_3d_reference_error(case, error) from error


def _flanks_under_load(expected: Sequence[ExpectedContacts]) -> tuple[int, ...]:
    """Return the sorted numbers of all groove flanks that may carry load, and of the flanks opposite to them on the ball.

    ``expected``: expected contacts of every load case. Flanks 0 to 3 are SL, SR, NL, NR (screw or nut, left or right); SL
    and NR are opposite, as are SR and NL.
    """
    return tuple(
        sorted({side for e in expected for touching in e.nearly_touching_flanks() for side in (touching, 3 - touching)})
    )


def flanks_to_mesh(scene: Scene) -> tuple[int, ...]:
    """Return the numbers of a scene's flanks that must be meshed: those that may carry load, and their opposite flanks.

    Flanks 0 to 3 are SL, SR, NL, NR (screw or nut, left or right); SL and NR are opposite on the ball, as are SR and NL.
    SceneNotCoveredError if the low-order estimate of the contact loads finds no equilibrium.
    """
    return _flanks_under_load(_estimate_expected_contacts(scene, ()))


def mesh_specifications(cases: Sequence[Solvable], level: int, variant: str = "") -> tuple[MeshSpecification, ...]:
    """Return what must be meshed on a mesh level for load cases of the same parts: bodies, flanks and mesh settings.

    Parameters
    ----------
    cases
        Load cases of the same parts.
    level
        Mesh level.
    variant
        Name of the modelling variant in `VARIANTS`; empty: none.

    Returns
    -------
    tuple of MeshSpecification
        One for each group of nut or bearing rows that have equal bodies and the same flanks to be meshed.

    Raises
    ------
    InputError
        If the level is unknown; its subclass SceneNotCoveredError if a row has no 3D model, or its contact loads cannot be
        estimated.
    """
    from rollbench.hifi.meshing.settings import Settings, round_up_lengths

    if level not in (SOURCE_LEVEL, *LEVELS):
        raise ArgumentError("levels", str(level), f"1 to {len(LEVELS)}", "choose a level in this range")
    bodies = _bodies_to_mesh(cases[0])
    expected = [*zip(*(_estimate_expected_contacts(case, bodies) for case in cases), strict=True)]
    shared: dict[tuple[Scene, tuple[int, ...]], list[int]] = {}
    for k, body in enumerate(bodies):
        shared.setdefault((body, _flanks_under_load(expected[k])), []).append(k)
    out = []
    for (body, sides), sets in shared.items():
        sizes = mesh_settings_of_level(level, body.balls.radius, VARIANTS[variant].refined if variant else ())
        contacts = [contact for k in sets for contact in expected[k]]
        semi = [round_up_lengths(contact.typical_semi_axes()) for contact in contacts]
        reach = [round_up_lengths(contact.largest_reach()) for contact in contacts]
        sizes["semi"] = (min(a for a, _ in semi), min(b for _, b in semi))
        sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
        sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
        out.append(MeshSpecification(body, sides, Settings(**sizes), tuple(sets)))
    return tuple(out)


def mesh_settings(scenes: Sequence[Scene], level: int, variant: str = "") -> Settings:
    """Return the mesh settings for scenes of one geometry, each with one nut or bearing row, on a mesh level.

    ``variant``: name of the modelling variant; empty: none. See `mesh_specifications`.
    """
    return mesh_specifications(scenes, level, variant)[0].mesh_settings


def mesh_settings_to_store(specifications: Sequence[MeshSpecification]) -> dict[str, Any]:
    """Return the mesh settings to store with a run of several nuts or bearing rows on one shaft.

    ``specifications``: bodies, flanks and mesh settings of all rows. The returned dictionary has the keys "b_over_h"
    (number of cells across the short semi-axis b of a contact ellipse) and "sets" (mesh settings and meshed flanks of each
    row).
    """
    by_set = {k: asdict(up.mesh_settings) | {"sides": up.meshed_flanks} for up in specifications for k in up.set_numbers}
    return {"b_over_h": specifications[0].mesh_settings.b_over_h, "sets": tuple(by_set[k] for k in sorted(by_set))}


def is_mesh_suitable(scene: Solvable, level: int, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> bool:
    """Return whether the meshes of a stored 3D run are suitable for a scene on a mesh level.

    ``variant``: name of the modelling variant; empty: none; ``settings``: mesh settings of the stored run; ``sides``:
    numbers of the flanks meshed in that run. The meshes are suitable if, compared with the meshes that the scene requires
    on this level, their contact cells are at least as fine and their contact patches at least as large, all flanks that may
    carry load are meshed, and all other settings are equal.
    """
    changed = VARIANTS[variant].change(scene) if variant and isinstance(scene, Scene) else scene
    try:
        wanted = mesh_settings_to_store(mesh_specifications([changed], level, variant))["sets"]
    except InputError:
        return False
    meshed = settings.get("sets", ({**settings, "sides": sides},))
    return len(meshed) == len(wanted) and all(
        _mesh_covers(mesh_settings_with_tuples(kept), need) for kept, need in zip(meshed, wanted, strict=True)
    )


def _mesh_covers(meshed: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    """Return whether a stored mesh can replace a required one.

    ``meshed``, ``wanted``: mesh settings and meshed flanks of the stored and of the required mesh. The stored mesh must
    have contact cells at least as fine and contact patches at least as large as the required mesh; it must contain all
    required flanks; and all other settings must be equal.
    """
    from rollbench.hifi.meshing.settings import Settings

    def text_of_settings_that_must_agree(mesh: Mapping[str, Any]) -> str:
        return canonical_text(RecordFields(Settings, {name: mesh[name] for name in wanted.keys() & mesh.keys() - _SIZED}))

    return (
        text_of_settings_that_must_agree(meshed) == text_of_settings_that_must_agree(wanted)
        and {"semi", "reach"} <= meshed.keys()
        and all(x <= y for x, y in zip(meshed["semi"], wanted["semi"], strict=True))
        and all(x >= y for x, y in zip(meshed["reach"], wanted["reach"], strict=True))
        and set(wanted["sides"]) <= set(meshed["sides"])
    )


def values_that_determine_meshes(scene: Solvable) -> tuple[Any, ...]:
    """Return the values of a scene (geometry, materials) that determine its meshes; scenes with equal values share them."""
    if isinstance(scene, Assembly):
        each = (
            (s.parts if not isinstance(s.parts, Scene) else values_that_determine_meshes(s.parts), s.position, s.carrier)
            for s in scene.sets
        )
        return (*each, scene.screw, scene.thermal_strain, stations_of_load_cases(scene))
    return scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw


def group_scenes_by_geometry(scenes: Sequence[Solvable]) -> list[list[Solvable]]:
    """Sort scenes into groups of equal geometry, which can share meshes, in the order of first occurrence."""
    alike: dict[object, list[Solvable]] = {}
    for scene in scenes:
        alike.setdefault(values_that_determine_meshes(scene), []).append(scene)
    return list(alike.values())


def mesh_settings_with_tuples(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return mesh settings read from JSON, with lists replaced by tuples."""

    def lists_to_tuples(value: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(map(lists_to_tuples, value))
        return mesh_settings_with_tuples(value) if isinstance(value, dict) else value

    return {name: lists_to_tuples(value) for name, value in settings.items()}


@dataclass(frozen=True)
class ReferenceTask:
    """One computation of the 3D reference: load cases of one geometry, solved on the meshes of one level."""

    #: Load cases of one geometry, as scenes.
    scenes: tuple[Solvable, ...]
    #: Mesh level.
    level: int
    #: Name of the modelling variant in `VARIANTS`; empty: none.
    variant: str = ""
    #: Whether the scenes are also solved with each part of the 3D model (such as the elastic nut) left out in turn.
    leave_out_each_part: bool = False
    #: Folder of the mesh cache; None: no cache.
    cache_folder: Path | None = None
    #: Number of processes that mesh and condense the parts.
    processes: int = 1
    #: Ratio of the cell size at the two ends where the 3D part of the shaft is cut off to the cell size of the mesh level.
    cut_end_cell_ratio: float = 1.0

    @property
    def single_row_scenes(self) -> tuple[Scene, ...]:
        """Those scenes of the task that have a single nut or bearing row."""
        return tuple(scene for scene in self.scenes if isinstance(scene, Scene))

    @property
    def label(self) -> str:
        """Description of the task for the terminal: scenes, mesh level, variant."""
        mesh = "the source's mesh" if self.level == SOURCE_LEVEL else f"level {self.level}"
        tail = f", {VARIANTS[self.variant].label}" if self.variant else ""
        return f"{', '.join(s.name for s in self.scenes)}: {mesh}{tail}"
