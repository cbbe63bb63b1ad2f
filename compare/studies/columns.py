"""Columns of what many solves answer: for each, its heading and how it follows from one solved scene.

A sweep stores these columns; to add one, add its line to `COLUMNS`. A column of balls takes them from
`SolvedScene.ball_sets`, of all nuts and ball bearings, and is None where there are none. With load cases, a value is that
of the case with the largest contact load, unless `row_of_duty_cycle` computes it from all. A table shows those columns
that `QUANTITIES` in `compare/results/table.py` names.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.measure import mean_load
from rollbench.compare.models import loading
from rollbench.compare.models.answers import results_of_contact_loads
from rollbench.compare.models.load_cases import contact_loads_by_nut_or_bearing, rating_life_over_duty_cycle
from rollbench.compare.models.many import Record
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model, run_model_on_scenes
from rollbench.compare.models.set_results import LifeByLoads
from rollbench.compare.models.stiffness import SceneStiffness, nuts_between, stiffness_of_scene
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.contacts import roller_contact_of_highest_pressure
from rollbench.lowfi.rating.displacement import displacement_of_load_point, load_point
from rollbench.lowfi.rating.iso_lives import roller_reference_life
from rollbench.lowfi.rating.life import basic_rating_life, turning_ring
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import SIDES, Scene


class SolvedSet(NamedTuple):
    """Nut or bearing row of a solved scene."""

    #: Beginning of the names of its contacts; empty for a scene with one nut or row.
    prefix: str
    #: Its geometry.
    parts: Scene | RollerRow
    #: Static result of its balls; None for rollers.
    balls: StaticResult | None
    #: Loads of its contacts or rollers [N].
    loads: Array
    #: Loads from which its life follows: of contacts [N], or of lines of rollers [N/m].
    life_loads: Array


@dataclass(frozen=True)
class SolvedScene:
    """Scene with one load case, and its static result."""

    #: The scene.
    scene: Scene | Assembly
    #: Name of the model.
    model: str
    #: Static result by the model.
    result: StaticResult | AxisResult
    #: Result of the scene with all external loads set to zero; None: it is solved where it is asked for.
    solved_unloaded: StaticResult | AxisResult | None = None

    @property
    def options(self) -> ModelOptions:
        """Options of the model."""
        return ModelOptions(estimate_beam_mesh_error=isinstance(self.scene, Assembly))

    @cached_property
    def sets(self) -> list[SolvedSet]:
        """Nuts and bearing rows of the scene."""
        if isinstance(self.result, StaticResult):
            assert isinstance(self.scene, Scene)
            return [SolvedSet("", self.scene, self.result, self.result.load, self.result.load)]
        lives = contact_loads_by_nut_or_bearing(self.result)
        return [
            SolvedSet(f"{s.of.name}: ", s.of.parts, s.balls, s.balls.load if s.balls else s.loads, lives[s.of.name])
            for s in self.result.sets
        ]

    @property
    def ball_sets(self) -> Iterator[tuple[Scene, StaticResult]]:
        """Geometry and static result of each nut and ball bearing."""
        return ((s.parts, s.balls) for s in self.sets if s.balls is not None and isinstance(s.parts, Scene))

    @cached_property
    def positive_loads(self) -> Array:
        """Loads of all loaded contacts and rollers [N]; balls come first."""
        ordered = sorted(self.sets, key=lambda s: s.balls is None)
        return np.concatenate([np.zeros(0), *(s.loads[s.loads > 0.0] for s in ordered)])

    @cached_property
    def unloaded(self) -> StaticResult | AxisResult:
        """Static result of the scene with all external loads set to zero."""
        if self.solved_unloaded is not None:
            return self.solved_unloaded
        if isinstance(self.scene, Scene):
            return loading.solve_with_scaled_loads(self.scene, 0.0, self.model, self.options)
        return run_model(loading.with_scaled_loads(self.scene, 0.0), self.model, self.options)

    @cached_property
    def stiffness(self) -> SceneStiffness:
        """Displacements and tangents of nut and load's point."""
        return stiffness_of_scene(self.scene, self.result, self.unloaded, self.model, self.options)

    @property
    def most_loaded(self) -> str:
        """Ball and flank of the contact with the largest load of all nuts and bearings, or number of the roller."""
        if not self.positive_loads.size:
            return ""
        s = max(sorted(self.sets, key=lambda s: s.balls is None), key=lambda s: float(s.loads.max(initial=0.0)))
        one, *side = np.unravel_index(int(s.loads.argmax()), s.loads.shape)
        roller = "roller " * (s.balls is None)
        return " ".join([f"{s.prefix}{roller}{one + 1}", *(SIDES[k] for k in side)])


def _displacement(solved: SolvedScene) -> float | None:
    """Return the displacement of the load's point to ground, from its nominal position [um]; None if not known."""
    point = load_point(solved.scene)
    moved = np.nan if point is None else 1e6 * displacement_of_load_point(solved.result, point)
    return None if np.isnan(moved) else moved


def _rigidity(solved: SolvedScene) -> float | None:
    """Return the axial secant of the nuts from the unloaded position [N/um], or of the bearings where there is no nut."""
    secant = nuts_between(solved.scene, solved.unloaded, solved.result).tangent
    return None if secant is None else 1e-6 * secant


def _preload(solved: SolvedScene) -> float | None:
    """Return the axial preload [N]: on a shaft, the largest axial force on a nut or bearing without external loads."""
    bare = solved.unloaded
    if not bare.converged:
        return None
    if isinstance(bare, AxisResult):
        return max((abs(float(s.force[2])) for s in bare.sets), default=0.0)
    assert isinstance(solved.scene, Scene)
    return loading.axial_preload(solved.scene, bare)


def _torque(solved: SolvedScene) -> Any:
    """Return what `compute_torques` computes the friction torque of balls from; None without friction."""
    from rollbench.compare.models.friction_sums import UnsolvedTorque

    friction = solved.scene.friction
    sets = [*solved.ball_sets]
    return None if friction is None else UnsolvedTorque(sets, friction, solved.scene.motion, solved.options.member)


def _life(solved: SolvedScene) -> float | None:
    """Return the shortest life of a nut (L10) or bearing (L10r) by the contact loads [10^6 revolutions].

    The result is None if no nut or bearing is loaded, or if a load rating is outside its range of validity.
    """
    rows = [None] if isinstance(solved.result, StaticResult) else [s.of for s in solved.result.sets]
    lives: list[LifeByLoads | None] = []
    try:
        for s, row in zip(solved.sets, rows, strict=True):
            ring = turning_ring(solved.scene, row)
            if isinstance(s.parts, RollerRow):
                lives.append(roller_reference_life(s.parts, s.life_loads, ring))
            else:
                lives.append(basic_rating_life(s.parts, s.life_loads, ring))
    except ValueError:
        return None
    return min((one.revolutions for one in lives if one is not None), default=None)


def largest_pressures(solved: SolvedScene) -> Iterator[float]:
    """Yield the largest Hertz pressure of each loaded nut or bearing row [Pa]."""
    for s in solved.sets:
        worst: Any
        if isinstance(s.parts, RollerRow):
            worst = roller_contact_of_highest_pressure(s.parts, s.life_loads)
        else:
            assert s.balls is not None, "a row of balls has contact loads"
            of_balls = (s.balls.load, s.balls.contact_angle, s.balls.member, s.balls.pressure)
            worst = results_of_contact_loads(s.parts, *of_balls).worst
        if worst is not None:
            yield worst.pressure


def _nominal_contacts(solved: SolvedScene) -> int:
    """Return the number of contacts over which the mean load is taken, see `mean_load`."""
    if isinstance(solved.scene, Scene) and isinstance(solved.result, StaticResult):
        return count_nominal_contacts(solved.scene, solved.result)
    return 0


class Column(NamedTuple):
    """Column of what many solves answer."""

    #: Heading, with its unit.
    heading: str
    #: Function that computes the value in the unit of the heading from a solved scene; None where it does not exist. It is
    #: called only if the column is asked for.
    value: Callable[[SolvedScene], Any]
    #: Whether the function asks for the solution of the scene without its loads.
    unloaded: bool = False


#: Column that decides which samples are the worst, and of which main effects and plots are made: the largest contact load.
#: It is always stored, with the contact that carries this load as ``at``.
MAIN = "largest_load_N"

#: Columns that compare the contact loads of load cases; a scene without load cases has None for them.
GROWTH = ("largest_growth", "least_growth")

_GROWTH = "largest load over that in the first load case, {} of all nuts and bearings"

#: Columns of a sweep, by the names of their JSON keys. Hertz approaches, friction torque and idle balls are of balls only,
#: without rollers. A torque needs a [friction] table in the scene.
COLUMNS = {
    MAIN: Column("largest contact load / N", lambda s: float(s.positive_loads.max(initial=0.0))),
    "mean_load_N": Column("mean contact load / N", lambda s: mean_load(s.positive_loads, _nominal_contacts(s))),
    "loaded_contacts": Column("number of loaded contacts", lambda s: int(s.positive_loads.size)),
    "idle_balls": Column(
        "number of balls without load",
        lambda s: sum(int(np.count_nonzero(~(balls.load > 0.0).any(axis=1))) for _, balls in s.ball_sets),
    ),
    "displacement_um": Column("displacement of the load's point to ground / um", _displacement),
    "largest_approach_um": Column(
        "largest approach of a contact / um",
        lambda s: max(
            (1e6 * float((x.hertz_C * np.cbrt(x.load) ** 2).max(initial=0.0)) for _, x in s.ball_sets), default=None
        ),
    ),
    "rigidity_N_per_um": Column("axial secant rigidity of the nut / (N/um)", _rigidity, unloaded=True),
    "preload_N": Column("axial preload / N", _preload, unloaded=True),
    "torque_Nmm": Column("friction torque / (N mm)", _torque),
    "life_million_revolutions": Column("life by the contact loads / 10^6 revolutions", _life),
    "largest_growth": Column(_GROWTH.format("largest ratio"), lambda _: None),
    "least_growth": Column(_GROWTH.format("smallest ratio"), lambda _: None),
}


def rows_of_scenes(
    scenes: Sequence[Scene | Assembly], model: str, wanted: Collection[str]
) -> list[tuple[SolvedScene, Record] | InputError]:
    """Solve load cases together; return each with its columns by name and "at", the contact with the largest load.

    ``wanted``: names of the columns, keys of `COLUMNS`. The record is empty without solution. Friction torques are left to
    `compute_torques`. An error stands in place of a load case that the model refuses.
    """
    results = run_model_on_scenes(scenes, model)
    asked = {name: column for name, column in COLUMNS.items() if name == MAIN or name in wanted}
    known: dict[int, StaticResult | AxisResult | InputError] = {}
    if any(column.unloaded for column in asked.values()):
        solved = [k for k, one in enumerate(results) if not isinstance(one, InputError) and one.converged]
        bare = run_model_on_scenes([loading.with_scaled_loads(scenes[k], 0.0) for k in solved], model)
        known = dict(zip(solved, bare, strict=True))

    def row(k: int) -> tuple[SolvedScene, Record] | InputError:
        """Return the load case with the number ``k`` and its columns, or its error."""
        result, unloaded = results[k], known.get(k)
        if isinstance(result, InputError):
            return result
        if isinstance(unloaded, InputError):
            return unloaded
        solved = SolvedScene(scenes[k], model, result, unloaded)
        if not result.converged:
            return solved, {}
        return solved, {name: column.value(solved) for name, column in asked.items()} | {"at": solved.most_loaded}

    return [row(k) for k in range(len(scenes))]


def row_of_scene(scene: Scene | Assembly, model: str, wanted: Collection[str]) -> tuple[SolvedScene, Record]:
    """Solve one load case as `rows_of_scenes`; raise InputError if the model refuses it."""
    (row,) = rows_of_scenes([scene], model, wanted)
    if isinstance(row, InputError):
        raise row
    return row


def row_of_duty_cycle(
    cycle: DutyCycle, solved: Sequence[SolvedScene], rows: Sequence[Record], wanted: Collection[str]
) -> Record:
    """Return the columns of a duty cycle from its solved load cases and their rows.

    They are those of the load case with the largest contact load, which "at" names, with three exceptions. Life is the
    shortest life of a nut or bearing over the duty cycle. The friction torque is the mean over all revolutions of the
    cycle. Growth is the ratio of the largest contact or roller load of a nut or bearing in any load case to the largest in
    the first load case; the columns are the largest and the smallest growth. ``wanted``: names of the columns.
    """
    case, worst = max(zip(cycle.cases, rows, strict=True), key=lambda pair: float(pair[1][MAIN]))
    compute_torques(rows)
    found = worst | {"at": f"case {case.name}: {worst['at']}"}
    if "torque_Nmm" in wanted:
        pairs = zip(cycle.revolution_shares, (one["torque_Nmm"] for one in rows), strict=True)
        torques = [(share, torque) for share, torque in pairs if share > 0.0]
        known = all(torque is not None for _, torque in torques)
        found["torque_Nmm"] = sum(share * torque for share, torque in torques) if known else None
    if "life_million_revolutions" in wanted:
        loads = [contact_loads_by_nut_or_bearing(one.result) for one in solved]
        lives = [rating_life_over_duty_cycle(cycle, name, [of[name] for of in loads])[0] for name in cycle.sets]
        rated = [x.revolutions for x in lives if x is not None]
        found["life_million_revolutions"] = min(rated) if len(rated) == len(lives) else None
    if any(name in wanted for name in GROWTH):
        tops = [[float(s.loads.max(initial=0.0)) for s in one.sets] for one in solved]
        ratios = [max(of_set) / of_set[0] for of_set in zip(*tops, strict=True) if of_set[0] > 0.0]
        ends = max(ratios, default=None), min(ratios, default=None)
        found |= {name: x for name, x in zip(GROWTH, ends, strict=True) if name in wanted}
    return found


def compute_torques(rows: Sequence[Record]) -> None:
    """Replace the friction torques that are not computed yet by numbers [N mm], all together; None without convergence.

    ``rows``: columns of samples or load cases by name.
    """
    asked = [one for one in rows if one.get("torque_Nmm") is not None]
    if not asked:
        return
    from rollbench.compare.models.friction_sums import UnsolvedTorque, total_friction_torques

    unsolved = [one for one in asked if isinstance(one["torque_Nmm"], UnsolvedTorque)]
    torques = total_friction_torques([one["torque_Nmm"] for one in unsolved])
    for one, torque in zip(unsolved, torques, strict=True):
        one["torque_Nmm"] = torque
