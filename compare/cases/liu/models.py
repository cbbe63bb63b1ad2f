"""Axial models of Liu et al. (2025), and of Mei et al. (2003), with whose model they begin."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rollbench.compare.models.model import Model, has_beam_screw

if TYPE_CHECKING:
    from rollbench.compare.models.model import ModelOptions
    from rollbench.lowfi.statics.result import StaticResult
    from rollbench.meshes.parts import Scene


def _solve_mei(scene: Scene, options: ModelOptions, *, elastic_nut: bool) -> StaticResult:
    """Solve a scene by the model of Mei et al.; ``elastic_nut``: whether the nut is an elastic bar instead of rigid."""
    from rollbench.lowfi.as_source.mei import solve_mei

    return solve_mei(scene, member=options.member, elastic_nut=elastic_nut)


def _solve_liu(scene: Scene, options: ModelOptions) -> StaticResult:
    """Solve a scene by the model of Liu et al.: balls in a row along the axis, load-dependent contact angles."""
    from rollbench.lowfi.as_source.liu.model import solve_liu

    return solve_liu(scene, member=options.member)


def _axial_stiffness_by_liu(scene: Scene, options: ModelOptions, step: float) -> float | None:
    """Return the axial stiffness of the nut by the model of Liu et al. [N/m], see `SpringRow.stiffness`."""
    from rollbench.lowfi.as_source.liu.model import nut_as_spring_row

    return nut_as_spring_row(scene, member=options.member).stiffness(step)


def _is_covered_by_mei_model(scene: Scene) -> bool:
    """Return whether the model of Mei et al. covers a scene: axial loads, no preload, one support, screw as a beam."""
    axial = all(x.force[0] == x.force[1] == 0.0 and not any(x.moment) for x in scene.loads)
    return axial and scene.errors.balls.oversize == 0.0 and len(scene.supports) == 1 and has_beam_screw(scene)


def _is_covered_by_liu_model(scene: Scene) -> bool:
    """Return whether the model of Liu et al. covers a scene.

    The model covers axial loads at one end of the nut, without preload and without a support that fixes the screw axially.
    """
    from rollbench.lowfi.as_source.liu.model import is_solvable_by_liu

    return is_solvable_by_liu(scene)


_BARS = "axial bars, and contact springs of fixed direction"
_NO_ASSEMBLY = "its bars connect the supports of the screw to a single fixed nut"
#: Models with which the publication computes.
MODELS = (
    Model(
        "mei",
        "axial bars and springs of fixed direction, rigid nut (Mei et al. 2003)",
        "Mei's model: axial bar, rigid nut",
        f"{_BARS}, nut rigid",
        partial(_solve_mei, elastic_nut=False),
        _NO_ASSEMBLY,
        covers_scene=_is_covered_by_mei_model,
        compared=True,
    ),
    Model(
        "mei-nut",
        "mei with the nut as an elastic bar fixed at its left face",
        "Mei's model: screw and nut as bars",
        f"{_BARS}, nut a bar",
        partial(_solve_mei, elastic_nut=True),
        _NO_ASSEMBLY,
        covers_scene=_is_covered_by_mei_model,
        compared=True,
    ),
    Model(
        "liu",
        "chain of balls along the axis that lose and gain contact, contact angles that turn, elastic nut (Liu et al. 2025)",
        "Liu's model: bars, angles vary with load",
        "axial bars, and contact springs whose direction turns; screw and nut each loaded at one end",
        _solve_liu,
        "it describes one row of balls between a screw and a nut, each loaded at one end",
        covers_scene=_is_covered_by_liu_model,
        compared=True,
        axial_stiffness=_axial_stiffness_by_liu,
    ),
)
