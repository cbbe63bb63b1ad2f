"""Stiffness of a solved scene: of the nut or bearing, and of the point on which the load acts, to ground.

Both displacements are defined in `rollbench.lowfi.rating.displacement`. Each has a secant, the change of the force over the
change of the displacement from the scene without its loads, and a tangent, the same for a small change of the scene's own
loads. The tangent is therefore a difference of two solutions: it contains all that the model lets change with the load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np

from rollbench.compare.models.loading import loaded_parts, with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.lowfi.rating import displacement
from rollbench.lowfi.rating.displacement import LoadPoint, load_point
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Load, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record

#: Change of the loads, in either direction, between the two solutions of a tangent, relative to the loads or to the largest
#: contact load that remains without them, whichever is larger.
STEP = 4e-5
#: Share of the contact loads that a small axial force has, by which a scene without loads is probed.
PROBE = 1e-4
#: Share of the load's change that a nut or bearing must take up, so that its stiffness is stated: less drowns in round-off.
LEAST_SHARE = 1e-4
#: Change of a displacement relative to the largest one that counts as round-off.
ROUND_OFF = 1e-9
#: Friction force [N] whose reversal causes the computed lost motion.
LOST_BY = 100.0


@result_record(kw_only=True)
class CrossMotion:
    """Displacement across the axis [m] and tilt [rad] of a section; None without loads across or moments."""

    across_x: float | None = quantity_or_none(
        "across_x_um", "displacement across, along x, from the scene without loads; null without loads across or moments"
    )
    across_y: float | None = quantity_or_none("across_y_um", "the same along y")
    tilt_x: float | None = quantity_or_none(
        "tilt_x_mrad", "tilt about x, from the scene without loads; null without loads across or moments"
    )
    tilt_y: float | None = quantity_or_none("tilt_y_mrad", "the same about y")

    @property
    @QuantityDescription(
        "across_um", "displacement across the axis", heading="displacement across", note="x {across_x_um}, y {across_y_um}"
    )
    def across(self) -> float | None:
        """Displacement across the axis [m]; None without loads across or moments."""
        return None if self.across_x is None or self.across_y is None else float(np.hypot(self.across_x, self.across_y))

    @property
    @QuantityDescription("tilt_mrad", "tilt", heading="tilt", note="about x {tilt_x_mrad}, about y {tilt_y_mrad}")
    def tilt(self) -> float | None:
        """Tilt [rad]; None without loads across or moments."""
        return None if self.tilt_x is None or self.tilt_y is None else float(np.hypot(self.tilt_x, self.tilt_y))


@result_record
class NutStiffness(CrossMotion):
    """Axial displacement [m] and stiffness [N/m] of one nut or bearing, or of several together, between their two parts.

    Displacement across and tilt are those of the screw's section in the nut, or of the inner in the outer ring; of several
    together they are None.
    """

    of: str = quantity_field("of", "nut or bearing, or how many of them together")
    force: float = quantity_field(
        "force_N", "axial force of the screw on the nut or bearing that the scene's loads cause; of several the sum"
    )
    displacement: float | None = quantity_field(
        "displacement_um",
        "axial displacement of the screw's section at the centre of the nut, relative to the nut, from the scene without "
        "loads, less lead/(2 pi) times its rotation relative to the nut (with the sign of the thread's hand); of a "
        "bearing, of the inner relative to the outer ring, at the section of its loaded contacts; without shaft, supports "
        "and wind-up; of several together, `force_N` over `secant_N_per_um`",
        heading="axial displacement",
    )
    secant: float | None = quantity_field(
        "secant_N_per_um",
        "force over displacement of the nut or bearing; of several the sum",
        heading="axial rigidity, secant",
    )
    tangent: float | None = quantity_field(
        "tangent_N_per_um",
        "change of force over change of displacement of the nut or bearing, between two solutions under slightly smaller "
        "and larger loads of the scene; without loads, under small axial forces; of several the sum",
        heading="axial rigidity, tangent",
        note="compare with a catalogue",
    )


@result_record
class LoadPointStiffness(CrossMotion):
    """Displacement [m], tilt [rad] and stiffness [N/m] of the point on which the load of a scene acts, to ground."""

    at: str = quantity_field("at", "axial position on the shaft, or housing, on which the load acts")
    along: str = quantity_field("along", "direction of force and displacement: z if the scene has an axial force")
    force: float = quantity_field("force_N", "sum of the scene's forces along this direction")
    displacement: float | None = quantity_field(
        "displacement_um",
        "displacement along this direction of the section or housing on which the load acts, from the scene without "
        "loads; with shaft, wind-up, supports and all bearings",
        error="`model_form.displacement_percent`, along z",
        heading="displacement",
        expected=("displacement", 1.0),
        note="at {at} along {along}",
    )
    secant: float | None = quantity_field(
        "secant_N_per_um",
        "force over displacement of the load's point",
        error="that of the displacement",
        heading="rigidity, secant",
        expected=("displacement", 1.0),
        note="at {at} along {along}",
    )
    tangent: float | None = quantity_field(
        "tangent_N_per_um",
        "change of force over change of displacement of the load's point, for a small change of the scene's own loads; "
        "without loads, for a small axial force",
        error="`model_form.rigidity_percent`, along z",
        heading="rigidity, tangent",
        expected=("rigidity", 1.0),
        note="with shaft and supports",
    )
    of: str = quantity_field("of", default="load's point")


@result_record
class ShaftPointStiffness(LoadPointStiffness):
    """Displacement, tilt and stiffness of the point on which the load of a shaft with several nuts or bearings acts."""

    @property
    @QuantityDescription(
        "lost_motion_um_per_100N",
        "displacement when a friction force of 100 N reverses: 2 x 100 N divided by the tangent stiffness",
        heading="lost motion, um by 100 N",
    )
    def lost_motion(self) -> float | None:
        """Lost motion: displacement [um] when a friction force of 100 N reverses; None without tangent stiffness."""
        return None if self.tangent is None else 1e6 * (2.0 * LOST_BY / self.tangent)


@result_record(kw_only=True)
class NutAndLoadPoint:
    """Tangents and displacements of the nut and of the load's point, in tables that compare scenes with one another.

    Where scenes stand side by side, those of nuts are null beside bearings, and those of loads along z beside loads across.
    """

    nut_tangent: float | None = quantity_or_none(
        "nut_tangent_N_per_um",
        "`nut.tangent_N_per_um`, without the shaft: of the nuts, or of the bearings without a nut",
        heading="nut: axial rigidity, tangent",
    )
    load_point_tangent: float | None = quantity_or_none(
        "load_point_tangent_N_per_um",
        "`load_point.tangent_N_per_um`, to ground",
        error="that of the rigidity, along z",
        heading="load's point: rigidity, tangent",
    )
    nut_displacement: float | None = quantity_or_none(
        "nut_displacement_um", "`nut.displacement_um`", heading="nut: axial displacement"
    )
    load_point_displacement: float | None = quantity_or_none(
        "load_point_displacement_um",
        "`load_point.displacement_um`",
        error="that of the displacement, along z",
        heading="load's point: displacement",
    )


@dataclass(frozen=True)
class SceneStiffness:
    """Stiffness of a solved scene at all its points."""

    #: Of each nut and bearing.
    sets: tuple[NutStiffness, ...]
    #: Of the point on which the load acts.
    load_point: LoadPointStiffness
    #: Why there is no tangent; empty if there is one, or if the model never gives one.
    words: str

    @property
    def nut(self) -> NutStiffness:
        """Stiffness of the nuts together or, without nuts, of the bearings together."""
        return stiffness_together(self.sets)


def stiffness_of_scene(
    scene: Scene | Assembly,
    result: StaticResult | AxisResult,
    unloaded: StaticResult | AxisResult,
    model: str,
    options: ModelOptions,
) -> SceneStiffness:
    """Compute displacements, secants and tangents of the nuts or bearings and of the load's point.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    result
        Converged result of the scene.
    unloaded
        Result of the scene without its loads. Displacements are measured from it, or from the nominal position where it
        has no equilibrium or, with one nut or bearing, no loaded contact.
    model
        Name of the model. No tangent is computed for models of users, whose numbers may be rounded.
    options
        Options of the model.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    point = load_point(scene)
    changed: Callable[[Any, float], Scene | Assembly] = with_scaled_loads
    base, step, unit = 1.0, change_of_loads(scene, unloaded), 0.0
    if point is None:  # probed by an axial force
        point, changed, base = LoadPoint(place_without_force(scene), (0.0, 0.0, 1.0), 0.0), with_axial_force, 0.0
        step, unit = PROBE * sum(float(balls.load.sum()) for balls in result.ball_results()), 1.0
    now, rest = _forces_and_displacements(scene, result, point), _at_rest(scene, unloaded, point)
    slope, words = np.full(now.shape, np.nan), ""
    if model in MODELS and step > 0.0:
        ends = [(changed(scene, base + x), x) for x in (-step, step)]
        solved = [(run_model(x, model, replace(options, estimate_beam_mesh_error=False)), change) for x, change in ends]
        words = next((f"under slightly changed loads: {x.status}" for x, _ in solved if not x.converged), "")
        if not words:
            low, high = (_forces_and_displacements(scene, x, point, unit or point.force, change) for x, change in solved)
            slope = high - low
    names = _kinds(scene, result)
    secants, tangents = ratios(now - rest), ratios(slope)
    if not is_axial(point):  # what a force across moves along the axis is no axial stiffness
        secants[:-1] = tangents[:-1] = [None] * len(names)
    each = zip(names, now - rest, secants, tangents, strict=False)
    *crossed, of_point = _cross_motions(scene, result, unloaded, point)
    sets = tuple(
        NutStiffness(of, float(f), _known(u), secant, tangent, **across)
        for (of, (f, u), secant, tangent), across in zip(each, crossed, strict=True)
    )
    force, moved = (now - rest)[-1]
    axes = zip("xyz", np.eye(3), strict=True)
    along = next((axis for axis, x in axes if np.allclose(np.abs(point.direction), x)), "the force")
    ratios_at_point = secants[-1], tangents[-1]
    kind = LoadPointStiffness if isinstance(scene, Scene) else ShaftPointStiffness
    of_load = kind(place_text(point.at), along, float(force), _known(moved), *ratios_at_point, **of_point)
    return SceneStiffness(sets, of_load, words)


def place_text(at: float | str) -> str:
    """Return the text of an axial position [m], or the name of a housing."""
    return at if isinstance(at, str) else f"{1e3 * at:.6g} mm"


@overload
def place_of_displacement(scene: Scene) -> float: ...


@overload
def place_of_displacement(scene: Scene | Assembly) -> float | str: ...


def place_of_displacement(scene: Scene | Assembly) -> float | str:
    """Return the place of a scene's displacement: where the load acts, or else where the scene is probed for stiffness."""
    point = load_point(scene)
    return place_without_force(scene) if point is None else point.at


def place_without_force(scene: Scene | Assembly) -> float | str:
    """Return where a scene without a force is probed: the nut's centre, or where an assembly's stiffness is reported."""
    if isinstance(scene, Scene):
        return scene.nut.position
    from rollbench.lowfi.statics.axis.system import location_of_reported_stiffness  # heavy import

    return location_of_reported_stiffness(scene)


def with_axial_force(scene: Scene | Assembly, force: float) -> Scene | Assembly:
    """Return a copy of a scene with an axial force [N] more, at `place_without_force`."""
    at, push = place_without_force(scene), (0.0, 0.0, force)
    if isinstance(at, str):
        assert isinstance(scene, Assembly), "only an assembly has housings"
        return replace(scene, housings=tuple(replace(h, force=push) if h.name == at else h for h in scene.housings))
    return replace(scene, loads=(*scene.loads, Load(at, push)))


def kind_of(parts: Scene | Assembly | RollerRow) -> str:
    """Return what a scene with one rolling set, or a row of rollers, describes: a nut or a bearing."""
    return "nut" if isinstance(parts, Scene) and parts.track.lead else "bearing"


def change_of_loads(scene: Scene | Assembly, unloaded: StaticResult | AxisResult) -> float:
    """Return the change of a scene's loads between the solutions of a tangent, relative to the loads.

    It is `STEP` of the loads or of the largest contact load that remains without them. A moment counts as the force at the
    first pitch radius. ``unloaded``: solution without the loads.
    """
    first = scene if isinstance(scene, Scene) else next((s.parts for s in scene.sets if isinstance(s.parts, Scene)), None)
    arm = 1.0 if first is None else first.track.pitch_radius
    wrenches = [(x.force, x.moment) for x in loaded_parts(scene)]
    size = max((float(np.linalg.norm([*force, *np.divide(moment, arm)])) for force, moment in wrenches), default=0.0)
    held = max((float(balls.load.max(initial=0.0)) for balls in unloaded.ball_results()), default=0.0)
    return STEP * max(1.0, held / size if size > 0.0 and unloaded.converged else 0.0)


def _forces_and_displacements(
    scene: Scene | Assembly, result: StaticResult | AxisResult, point: LoadPoint, unit: float = 0.0, change: float = 0.0
) -> Array:
    """Return force [N] and displacement [m] of each nut or bearing and, in the last row, of the load's point, (n + 1, 2).

    The load is that of ``point``, and ``change`` times ``unit`` [N] more.
    """
    forces = [-float(s.force[2]) for s in result.sets] if isinstance(result, AxisResult) else [axial_force(result)]
    rows = np.column_stack([forces, displacement.displacements_of_sets(scene, result)])
    return np.array([*rows, (point.force + change * unit, displacement.displacement_of_load_point(result, point))])


def has_cross_loads(scene: Scene | Assembly) -> bool:
    """Return whether a scene has forces across its axis, or moments about a line across it."""
    return any(np.any(vector[:2]) for x in loaded_parts(scene) for vector in (x.force, x.moment))


def _cross_motions(
    scene: Scene | Assembly, result: StaticResult | AxisResult, unloaded: StaticResult | AxisResult, point: LoadPoint
) -> list[dict[str, Any]]:
    """Return the fields of `CrossMotion` of each nut or bearing and, last, of the load's point.

    They are None without loads across or moments, and where the model gives no motion. Arguments as `stiffness_of_scene`.
    """
    names = ("across_x", "across_y", "tilt_x", "tilt_y")

    def motions(solved: StaticResult | AxisResult) -> Array:
        """Return the motions (n + 1, 6) [m, rad] of a solution."""
        return np.array([*displacement.motions_in_sets(scene, solved), displacement.motion_at(solved, point.at)])

    now = motions(result)
    if not has_cross_loads(scene):
        return [dict.fromkeys(names)] * len(now)
    moved = now - motions(unloaded) if _holds(unloaded) else now
    least = ROUND_OFF * np.array([np.nanmax(np.abs(moved[:, part]), initial=0.0) for part in (slice(3), slice(3, 6))])
    moved = np.where(np.abs(moved) > np.repeat(least, 3), moved, np.where(np.isnan(moved), np.nan, 0.0))
    return [
        {name: None if np.isnan(x) else float(x) for name, x in zip(names, row[[0, 1, 3, 4]], strict=True)} for row in moved
    ]


def _holds(unloaded: StaticResult | AxisResult) -> bool:
    """Return whether the position of a scene without its loads is known.

    It is not without an equilibrium or, with one nut or bearing, without a loaded contact.
    """
    return unloaded.converged and (isinstance(unloaded, AxisResult) or bool((unloaded.load > 0.0).any()))


def is_axial(point: LoadPoint) -> bool:
    """Return whether displacement and force of a load's point are those along the axis."""
    return point.direction[2] == 1.0


def nuts_between(
    scene: Scene | Assembly, first: StaticResult | AxisResult, second: StaticResult | AxisResult
) -> NutStiffness:
    """Return displacement and stiffness of the nuts together, or of the bearings without a nut, between two solutions.

    ``scene``: the scene of the second solution; ``first``: converged solution under other loads, or without loads. There is
    no tangent where the scene's load acts across.
    """
    point, own = LoadPoint(place_of_displacement(scene), (0.0, 0.0, 1.0), 0.0), load_point(scene)
    changes = _forces_and_displacements(scene, second, point) - _at_rest(scene, first, point)
    each = zip(_kinds(scene, second), changes, ratios(changes), strict=False)
    found = stiffness_together([NutStiffness(kind, float(f), float(u), ratio, ratio) for kind, (f, u), ratio in each])
    return found if own is None or is_axial(own) else replace(found, tangent=None)


def _kinds(scene: Scene | Assembly, result: StaticResult | AxisResult) -> list[str]:
    """Return what each rolling set of a solved scene is: a nut or a bearing."""
    return [kind_of(s.of.parts) for s in result.sets] if isinstance(result, AxisResult) else [kind_of(scene)]


def _at_rest(scene: Scene | Assembly, unloaded: StaticResult | AxisResult, point: LoadPoint) -> Array:
    """Return forces and displacements (n + 1, 2) of a scene without its loads, from which those under loads are counted.

    Zero where it has no equilibrium or, with one nut or bearing, no loaded contact, so that its position is arbitrary.
    """
    rows = _forces_and_displacements(scene, unloaded, point)
    rows[-1, 0] = 0.0
    return rows if _holds(unloaded) else np.zeros(rows.shape)


def ratios(changes: Array) -> list[float | None]:
    """Return force over displacement [N/m] for each row of ``changes`` (n, 2).

    None for unlike signs, round-off, and less than `LEAST_SHARE` of the largest force.
    """
    least = np.array([LEAST_SHARE, ROUND_OFF]) * np.abs(changes).max(axis=0, initial=0.0)
    return [float(f / u) if f * u > 0.0 and abs(f) > least[0] and abs(u) > least[1] else None for f, u in changes]


def _known(value: float) -> float | None:
    """Return a displacement, or None for nan and where nothing moves."""
    return None if np.isnan(value) or not value else float(value)


def stiffness_together(sets: Sequence[NutStiffness]) -> NutStiffness:
    """Return the stiffness of all nuts together, or of all bearings where there is no nut, as springs side by side."""
    nuts = [x for x in sets if x.of == "nut"]
    chosen = nuts or list(sets)
    if len(chosen) == 1:
        return chosen[0]
    force = sum(x.force for x in chosen)
    secant = sum(x.secant for x in chosen if x.secant is not None) or None
    tangent = sum(x.tangent for x in chosen if x.tangent is not None) or None
    moved = None if secant is None else force / secant
    return NutStiffness(f"{len(chosen)} {'nuts' if nuts else 'bearings'}", force, moved, secant, tangent)
