"""Load curve of a scene: displacement and stiffness over a range of loads, and the backlash between loads of both signs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.many import StoredIn, in_order, solve_many
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import default_model_name, run_model
from rollbench.compare.models.stiffness import nuts_between, place_of_displacement
from rollbench.compare.quantities import quantity_value, record_as_json
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version, values_in_words
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes import units
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Load, Scene
from rollbench.meshes.quantity import quantity_field, result_record
from rollbench.reports.content import Figure, Panel, Series

#: Default and largest number of points of a curve, and number of points that are solved and stored together.
POINTS, MOST, TOGETHER = 21, 1001, 7
#: Relative change of the load for the tangent stiffness; fraction of the largest load that counts as a vanishing load.
STEP, VANISHING = 1e-3, 1e-6
#: Form of the text that states a range of loads, for error messages.
FORM = (
    "LOW:HIGH, if needed followed by the number of loads such as :41, by the direction of the force :x, :y, :z or an angle "
    "from x to y such as :45deg, and by its point of application, an axial position such as :300mm or the name of a housing"
)
#: Axis labels of the panels of the figure, by JSON keys of `CurvePoint`.
LABELS = {
    "load_point_displacement_um": "displacement of the load's point / µm",
    "load_point_tangent_N_per_um": "tangent stiffness of the load's point / (N/µm)",
    "nut_displacement_um": "displacement of the nut / µm",
    "nut_tangent_N_per_um": "tangent stiffness of the nut / (N/µm)",
    "largest_load_N": "largest contact load / N",
    "friction_torque_Nmm": "friction torque / (N mm)",
}
#: Unit vectors of the axes, by name.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: Components of a vector along x, y and z.
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class LoadRange:
    """Range of loads over which a load curve is computed: values, direction, and the point on which they act."""

    values: tuple[float, ...]
    """Forces [N], or factors by which the scene's loads are multiplied, in ascending order."""
    factors: bool = False
    """Whether the values are factors."""
    direction: Vector = AXES["z"]
    """Unit vector of the forces."""
    at: float | str | None = None
    """Axial position on the shaft [m], or name of the housing, on which the forces act. None: the point on which the
    scene's own load acts; without one, the nut's centre, or for several nuts or bearings ``stiffness_at``."""


def read_load_range(text: str) -> LoadRange:
    """Convert the text of a range of loads, such as ``"-3kN:3kN:41:x"``, to a record.

    Parameters
    ----------
    text
        ``LOW:HIGH``, optionally followed by the number of points, the direction, and the axial position or housing; see
        `rollbench.load_curve`.

    Returns
    -------
    LoadRange
        The range of loads.

    Raises
    ------
    ArgumentError
        If the text has another form.

    Examples
    --------
    >>> course = read_load_range("-3kN:3kN:3:x")
    >>> course.values, course.direction
    ((-3000.0, 0.0, 3000.0), (1.0, 0.0, 0.0))
    >>> read_load_range("0:1.5:2").factors
    True
    """

    def refused(allowed: str, advice: str) -> ArgumentError:
        """Return the error to raise for the text."""
        return ArgumentError("curve", units.toml_text(text), allowed, advice)

    ends, further = text.split(":")[:2], [x.strip() for x in text.split(":")[2:]]
    pairs = [units.split_quantity_text(end) for end in ends]
    if len(pairs) < 2 or any(pair is None for pair in pairs):
        raise refused(FORM, 'write `curve="-3000N:3000N"`, or 0:1.5 for multiples of the scene\'s loads')
    factors = not any(pair and pair[1] for pair in pairs)
    try:
        low, high = (float(end) if factors else units.parse_quantity(end, "force") for end in ends)
    except ValueError as error:
        raise refused(FORM, str(error)) from None
    points, direction, at = POINTS, AXES["z"], None
    for word in further:
        kind = (units.split_quantity_text(word) or ("", ""))[1]
        if word.isdigit():
            points = int(word)
        elif word in AXES or kind in ("deg", "°", "rad"):
            turn = 0.0 if word in AXES else units.parse_quantity(word, "angle")
            direction = AXES.get(word, (math.cos(turn), math.sin(turn), 0.0))
        else:
            at = _axial_position(word) if kind else word
    if not (low < high and 2 <= points <= MOST):
        raise refused(f"LOW below HIGH, and 2 to {MOST} points (loads)", f"write {FORM}")
    if factors and (direction != AXES["z"] or at is not None):
        allowed = "a direction or position only with forces: multiples of the scene's loads keep their own"
        raise refused(allowed, "leave out direction and position, or write forces with a unit")
    return LoadRange(tuple(np.linspace(low, high, points).tolist()), factors, direction, at)


def _axial_position(word: str) -> float:
    """Convert a text such as ``"300mm"`` to an axial position [m]; ArgumentError if it is no length."""
    try:
        return units.parse_quantity(word, "length")
    except ValueError as error:
        raise ArgumentError("curve", units.toml_text(word), FORM, str(error)) from None


@result_record(kw_only=True)
class CurvePoint:
    """Displacement, stiffness, largest contact load and friction torque at one load of a load curve.

    A number is None if there is no equilibrium, or if the displacement is not unique because the load is zero and the nut
    has backlash; `status` says which.
    """

    load: float = quantity_field(
        "load_N", "force along the curve's direction; for load factors, the force of the first load"
    )
    factor: float | None = quantity_field(
        "load_factor", "factor on all loads of the scene, if the curve is over load factors"
    )
    displacement: float | None = quantity_field(
        "load_point_displacement_um",
        "displacement of the loaded point along the force, to ground, from its position without loads (without preload: "
        "from its nominal position)",
        error="that of `load_point.displacement_um`",
    )
    stiffness: float | None = quantity_field(
        "load_point_tangent_N_per_um",
        "tangent of the curve: difference between 0.1 % more and 0.1 % less load, divided by the difference of the "
        "displacements of the loaded point",
        error="that of `load_point.tangent_N_per_um`",
    )
    nut_displacement: float | None = quantity_field(
        "nut_displacement_um",
        "axial displacement of the nut as `nut.displacement_um`, from the same position; of several nuts, or bearings "
        "where there is no nut, their force over the sum of their secants",
    )
    nut_stiffness: float | None = quantity_field(
        "nut_tangent_N_per_um",
        "tangent of the nut as `nut.tangent_N_per_um`, between 0.1 % more and 0.1 % less load; of several nuts, or "
        "bearings where there is no nut, the sum",
    )
    largest: float | None = quantity_field(
        "largest_load_N", "largest load of a contact or roller", error="as `loads.max_N`"
    )
    torque: float | None = quantity_field(
        "friction_torque_Nmm", "friction torque, if the scene has a coefficient of friction"
    )
    status: str = quantity_field("status", "converged, or the reason why this point has no values")


@result_record(eq=False, repr=False, kw_only=True)
class LoadCurve(TabularRecord):
    """Displacement and stiffness of a scene over a range of loads that replace or scale its own loads.

    Examples
    --------
    >>> import rollbench
    >>> curve = rollbench.load_curve("lin-case1", "-3000N:3000N:5", "lin")
    >>> curve.lash, round(curve.forward / 1e6)  # m, N/um
    (0.0, 135)
    """

    scene: str = quantity_field("scene")
    """Name of the scene."""
    model: str = quantity_field("model")
    """Name of the model."""
    member: int = quantity_field("member")
    """Number of the specimen, from 0, in a scene with random errors."""
    direction: Vector = quantity_field("direction", "unit vector of the force", parts="[]")
    at: str = quantity_field(
        "at", "axial position of the screw or shaft, or housing, on which the force acts and whose displacement is stated"
    )
    lash: float | None = quantity_field(
        "lash_um",
        "backlash: difference of the displacements for a vanishing positive and a vanishing negative load, so without any "
        "elastic part; 0 with preload",
        error="about 1 nm; smaller values are set to 0",
    )
    lash_words: str | None = quantity_field("lash_words", "reason why no backlash can be computed")
    peak_to_peak: float | None = quantity_field(
        "peak_to_peak_um",
        "displacement at the largest load minus that at the smallest: backlash and elastic part, as a test measures them",
    )
    forward: float | None = quantity_field(
        "stiffness_above_N_per_um",
        "stiffness outside the backlash under positive loads: the largest load, divided by the displacement from the upper "
        "end of the backlash",
        error="that of the rigidity",
    )
    backward: float | None = quantity_field(
        "stiffness_below_N_per_um",
        "stiffness outside the backlash under negative loads, from the lower end of the backlash",
        error="that of the rigidity",
    )
    points: tuple[CurvePoint, ...] = quantity_field("points")
    """Displacement, stiffness and other values at each load of the curve."""
    warnings: tuple[ResultWarning, ...] = quantity_field("warnings")
    """Warnings about the solutions at the two ends of the curve."""
    assumed: tuple[str, ...] = quantity_field("assumed")
    """Assumptions made by the scene and by the model."""

    @property
    def converged(self) -> bool:
        """Whether an equilibrium was found at every load."""
        return all(p.largest is not None for p in self.points)

    @property
    def above(self) -> str:
        """Line of warnings that is printed above the results; empty if there are none."""
        return join_brief_warnings(self.warnings)

    def to_dict(self) -> dict[str, JSON]:
        """Return the curve as a dictionary, as ``rollbench solve --curve --json`` prints it.

        Returns
        -------
        dict
            JSON values by key.
        """
        return add_schema_version(record_as_json(self))

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each load.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return [record_as_json(point) for point in self.points]

    @property
    def _notes(self) -> tuple[str, ...]:
        """Lines below the table: values of the whole curve, such as its lash, then the warnings."""
        return (values_in_words(record_as_json(self, "points", "warnings", "assumed")), *self.warnings)

    def figure(self) -> Figure | None:
        """Return the figure of the curve: a panel for each computed quantity, with the load on the horizontal axis.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        panels = []
        for column, label in LABELS.items():
            known = [(1e-3 * p.load, y) for p in self.points if (y := quantity_value(p, column)) is not None]
            if known:
                x, y = zip(*known, strict=True)
                series = [Series(self.scene, x, y)]
                panels.append(Panel(label.split(" /")[0], "load / kN", label, series, include_zero=True))
        return Figure("load-curve", f"{self.scene} over its load", panels) if panels else None


@dataclass(frozen=True)
class _SolutionAtLoad:
    """Solution of the scene under one load of a load curve."""

    #: Scene with this load.
    scene: Scene | Assembly
    #: Result of the model for this scene.
    result: StaticResult | AxisResult
    #: Displacement of the loaded point along the force [m]; nan without equilibrium.
    displacement: float = math.nan
    #: Largest contact load [N]; nan without equilibrium.
    largest_load: float = math.nan


def compute_load_curve(
    scene: Scene | Assembly,
    course: LoadRange,
    model: str = "",
    options: ModelOptions | None = None,
    stored: StoredIn | None = None,
) -> LoadCurve:
    """Solve a scene over a range of loads, for displacement, stiffness and backlash.

    Forces replace the scene's loads. They act where the scene's load acts, unless ``course`` states another point. Factors
    multiply all loads of the scene; the curve is then plotted over the first of these loads.

    Parameters
    ----------
    scene
        Scene with one load case.
    course
        Range of loads.
    model
        Name of the model; if empty, the default model of the scene.
    options
        Options of the model.
    stored
        Folder in which solved points are looked up and stored; None: none.

    Returns
    -------
    LoadCurve
        A point for each load, the backlash, and the stiffness outside the backlash.

    Raises
    ------
    rollbench.InputError
        If the range of loads does not fit the scene, or the model does not cover the scene.

    Notes
    -----
    Under a small force F, the displacement is u(F) = u_0 + c F^(2/3) (Hertz), with the displacement u_0 at the end of the
    backlash and a constant c. So u_0 = (4 u(F/8) - u(F))/3 for a vanishing force F.
    """
    model, options = model or default_model_name(scene), replace(options or ModelOptions(), estimate_beam_mesh_error=False)
    loaded, direction, at, unit = _load_function_and_direction(scene, course)

    @cache
    def solution_at_load(value: float) -> _SolutionAtLoad:
        """Solve the scene under one force [N] or load factor."""
        here = loaded(value)
        result = run_model(here, model, options)
        if not result.converged:
            return _SolutionAtLoad(here, result)
        loads = [result.load] if isinstance(result, StaticResult) else [s.loads for s in result.sets]
        moved = float(np.dot(motion_at(result, at)[:3], direction))
        return _SolutionAtLoad(here, result, moved, max(float(np.max(x, initial=0.0)) for x in loads))

    bare = solution_at_load(0.0)
    pressed = bare.largest_load > 0.0
    start = bare.displacement if pressed else 0.0
    top = max(map(abs, course.values))
    ends, words = _backlash_limits(course, lambda f: solution_at_load(f).displacement, top)
    lash = None if ends is None else ends[1] - ends[0]

    def tangents_at_load(value: float) -> tuple[float | None, float | None]:
        """Return the tangents of load's point and nut [N/m] at a force [N] or load factor; None within the backlash."""
        step = STEP * (abs(value) if abs(value) > STEP * top else top)
        low, high = solution_at_load(value - step), solution_at_load(value + step)
        if (abs(value) <= STEP * top and not (pressed and not lash)) or not (
            low.result.converged and high.result.converged
        ):
            return None, None
        moved = high.displacement - low.displacement
        nut = nuts_between(low.scene, low.result, high.result).tangent
        return 2.0 * step * unit / moved if moved and math.isfinite(moved) else None, nut

    def point_at_load(value: float, torque: float | None) -> CurvePoint:
        """Return the curve's point at a force [N] or load factor; ``torque``: friction torque [N m]."""
        s, free = solution_at_load(value), value == 0.0 and bool(lash)
        tangent, nut_tangent = tangents_at_load(value)
        known = s.result.converged and not free
        return CurvePoint(
            load=value * unit,
            factor=value if course.factors else None,
            displacement=None if free or math.isnan(s.displacement) else s.displacement - start,
            stiffness=tangent,
            nut_displacement=nuts_between(s.scene, bare.result, s.result).displacement if known else None,
            nut_stiffness=nut_tangent,
            largest=None if math.isnan(s.largest_load) else s.largest_load,
            torque=torque,
            status="displacement not unique: anywhere within the backlash" if free else s.result.status,
        )

    def points_at_loads(*values: float) -> tuple[CurvePoint, ...]:
        """Return the curve's points at several forces [N] or load factors, whose friction is solved together."""
        torques = _friction_torques([solution_at_load(value) for value in values], options.member)
        return tuple(map(point_at_load, values, torques))

    rows = {k: course.values[k : k + TOGETHER] for k in range(0, len(course.values), TOGETHER)}
    solved = in_order(solve_many(points_at_loads, rows, stored=stored), [*rows])
    points = [point for _, each in solved for point in each]
    known = [p for p in points if p.displacement is not None]
    of_ends = [solution_at_load(course.values[k]).result for k in (0, -1)]
    return LoadCurve(
        scene=scene.name,
        model=model,
        member=options.member,
        direction=direction,
        at=at if isinstance(at, str) else f"{1e3 * at:.6g} mm",
        lash=lash,
        lash_words=words or None,
        peak_to_peak=known[-1].displacement - known[0].displacement if len(known) > 1 else None,  # type: ignore[operator]
        forward=None if ends is None else _secant_stiffness_outside_backlash(points[-1], ends[1] - start),
        backward=None if ends is None else _secant_stiffness_outside_backlash(points[0], ends[0] - start),
        points=tuple(points),
        warnings=tuple(dict.fromkeys(w for result in of_ends for w in result.warnings)),
        assumed=bare.result.assumed,
    )


def _load_function_and_direction(
    scene: Scene | Assembly, course: LoadRange
) -> tuple[Callable[[float], Scene | Assembly], Vector, float | str, float]:
    """Return a function that applies one load of a load curve to the scene, and direction and position of this load.

    Returns, in this order: the function, which gets a force [N] or load factor and returns the scene under this load; the
    unit vector of the force; the axial position [m] or housing on which it acts; and the force [N] for a load of 1: 1 N or,
    if the loads are load factors, the magnitude of the force on this housing in the scene or, without a housing, of the
    first force of the scene. ``course``: range of loads. Raises ArgumentError if the range does not fit the scene.
    """
    at = place_of_displacement(scene)
    if course.factors:
        given = [h.force for h in scene.housings if h.name == at] if isinstance(scene, Assembly) else []
        force = (given or [x.force for x in scene.loads] or [(0.0, 0.0, 0.0)])[0]
        size = float(np.linalg.norm(force))
        if not size:
            stated = "multiples of the scene's loads"
            allowed = "multiples of the loads only for a scene whose first load is a force"
            raise ArgumentError("curve", stated, allowed, "write forces, such as -3000N:3000N", scene.name)
        x, y, z = (f / size for f in force)
        return lambda value: with_scaled_loads(scene, value), (x, y, z), at, size
    at = at if course.at is None else course.at
    housings = [h.name for h in scene.housings] if isinstance(scene, Assembly) else []
    if (at not in housings) if isinstance(at, str) else not 0.0 <= at <= scene.screw.length:
        allowed = ", ".join([f"0 mm to {1e3 * scene.screw.length:g} mm", *housings])
        advice = f"state an axial position on the {'shaft, or a housing' if isinstance(scene, Assembly) else 'screw'}"
        raise ArgumentError("curve", at if isinstance(at, str) else f"{1e3 * at:g} mm", allowed, advice, scene.name)

    def scene_under_force(value: float) -> Scene | Assembly:
        """Return the scene with a force [N] in place of its own loads."""
        x, y, z = (value * part for part in course.direction)
        bare = with_scaled_loads(scene, 0.0)
        if isinstance(bare, Assembly):
            bare = replace(bare, stiffness_at=at)
        if isinstance(at, str) and isinstance(bare, Assembly):
            return replace(bare, housings=tuple(replace(h, force=(x, y, z)) if h.name == at else h for h in bare.housings))
        return replace(bare, loads=(Load(float(at), (x, y, z)),) if value else ())

    return scene_under_force, course.direction, at, 1.0


def _backlash_limits(
    course: LoadRange, displacement_at: Callable[[float], float], largest_load: float
) -> tuple[tuple[float, float] | None, str]:
    """Return the displacements at both ends of the backlash [m], or None and the reason why no backlash can be computed.

    The second value is a text, empty if there is a backlash. ``course``: range of loads. ``displacement_at``: function that
    returns the displacement [m] under a load. ``largest_load``: largest absolute load. The end of the backlash is
    extrapolated from vanishing loads; ends closer than the accuracy of the extrapolation are made equal.
    """
    if not course.values[0] < 0.0 < course.values[-1]:
        return None, "all loads have the same sign"
    ends, rough = [], 0.0
    for sign in (-1.0, 1.0):
        force = sign * VANISHING * largest_load
        near, far = displacement_at(force / 8.0), displacement_at(force)
        if math.isnan(near) or math.isnan(far):
            return None, f"no equilibrium under a vanishing {'positive' if sign > 0.0 else 'negative'} load"
        ends.append((4.0 * near - far) / 3.0)
        rough += abs(far - near)
    if abs(ends[1] - ends[0]) <= rough:
        ends = [0.5 * (ends[0] + ends[1])] * 2
    return (ends[0], ends[1]), ""


def _friction_torques(solutions: Sequence[_SolutionAtLoad], member: int) -> list[float | None]:
    """Return the friction torque [N m] at each solution; None without friction, and for an axis or balls without load.

    ``member``: number of the random draw of the geometric errors.
    """
    pressed = [
        (k, (s.scene, s.scene.friction, s.result))
        for k, s in enumerate(solutions)
        if isinstance(s.scene, Scene) and isinstance(s.result, StaticResult) and s.scene.friction and s.largest_load > 0.0
    ]
    torques: list[float | None] = [None] * len(solutions)
    if not pressed:
        return torques
    from rollbench.compare.models.friction_sums import friction_results_of_scenes  # heavy import

    for (k, _), (found, _) in zip(pressed, friction_results_of_scenes([of for _, of in pressed], member), strict=True):
        torques[k] = None if found is None else found.torque
    return torques


def _secant_stiffness_outside_backlash(end: CurvePoint, backlash_end: float) -> float | None:
    """Return the secant stiffness [N/m] between one end of the backlash and the load curve's last point on that side.

    ``end``: last point of the curve. ``backlash_end``: displacement at the end of the backlash [m]. Returns None if there
    is no equilibrium at the curve's last point.
    """
    moved = None if end.displacement is None else end.displacement - backlash_end
    return end.load / moved if moved else None
