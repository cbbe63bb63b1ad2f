"""Samples of a sweep: the scene with other values, its solution, and its outputs."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.measure import mean_load
from rollbench.compare.models import loading
from rollbench.compare.models.load_cases import contact_loads_by_nut_or_bearing, rating_life_over_duty_cycle
from rollbench.compare.models.many import CONVERGED, Record, stored_records
from rollbench.compare.models.registry import AXIS_MODELS, ModelOptions, model_by_name, run_model
from rollbench.compare.models.stiffness import secant_of_nuts
from rollbench.compare.scenes import catalogue, scene_file, scene_tables
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.studies.sweep.keys import VariedKey, tables_with_varied_keys, varied_and_replaced_keys
from rollbench.lowfi.rating.displacement import displacement_of_load_point, load_point
from rollbench.lowfi.rating.iso_lives import roller_reference_life
from rollbench.lowfi.rating.life import TurningRing, basic_rating_life, turning_ring
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import SIDES, Scene

if TYPE_CHECKING:
    from rollbench.compare.models.friction_sums import UnsolvedTorque

#: Outputs of a sample: name of the output, and its heading in tables.
OUTPUTS = {
    "largest_load_N": "largest contact load / N",
    "mean_load_N": "mean contact load / N",
    "loaded_contacts": "loaded contacts",
    "idle_balls": "balls without load",
    "displacement_um": "displacement of the load's point to ground / um",
    "largest_approach_um": "largest approach of a contact / um",
    "rigidity_N_per_um": "axial secant rigidity of the nut / (N/um)",
    "preload_N": "axial preload / N",
    "torque_Nmm": "friction torque / (N mm)",
    "life_million_revolutions": "life by the contact loads / 10^6 revolutions",
    "largest_growth": "largest load over that in the first load case, largest ratio of all nuts and bearings",
    "least_growth": "largest load over that in the first load case, smallest ratio of all nuts and bearings",
}
#: Outputs that compare the contact loads of load cases; a scene without load cases has None for them.
GROWTH = ("largest_growth", "least_growth")


#: Output that decides which samples are the worst, and of which main effects and plots are made: the largest contact load.
#: It is always stored, with the contact that carries this load as ``at``.
MAIN = "largest_load_N"


@lru_cache(maxsize=8)
def _cached_toml_tables(text: str, origin: str) -> dict[str, Any]:
    """Return the TOML tables in the text of a scene file; equal texts are read only once.

    ``origin``: name of the file for error messages.
    """
    return scene_file.parse_toml(text, origin)


@dataclass(frozen=True)
class VariedScene:
    """Scene of which some keys vary."""

    #: Text of the scene file.
    text: str
    #: Name of the scene or of its file, which error messages show.
    origin: str
    #: Keys of the scene that are varied, with their ranges or values.
    keys: tuple[VariedKey, ...]

    @property
    def file_name(self) -> str:
        """Name of the scene file without the folder in which it lies; results name the scene by it."""
        return Path(self.origin).name

    def check_keys(self) -> None:
        """Raise InputError if the scene does not allow a value of a key."""
        raw = scene_file.parse_toml(self.text, self.origin)
        for vary in self.keys:
            for value in vary.trial_values:
                scene_tables.validated_keys(tables_with_varied_keys(raw, [vary], [value]), self.origin)

    def say_which_keys_are_replaced(self, show_progress: Callable[[str], None]) -> None:
        """Show a line for each key of the scene that a varied key replaces."""
        for path, other in varied_and_replaced_keys(scene_file.parse_toml(self.text, self.origin), self.keys):
            show_progress(f"{path} replaces {other} of the scene")

    def at(self, values: Sequence[Any], origin: str = "") -> Described:
        """Return the scene with a value of each varied key; InputError if it does not allow them.

        ``origin``: name of the scene file in errors; if empty, `file_name`.
        """
        origin = origin or self.file_name
        tables = tables_with_varied_keys(_cached_toml_tables(self.text, origin), self.keys, values)
        return scene_tables.scene_from_tables(tables, origin)


def check_model(scene: Described, model: str) -> None:
    """Raise InputError if the model is unknown, or does not cover the scene."""
    if not isinstance(scene, Assembly):
        model_by_name(model, excluded_names=("condensed",))
    elif model not in AXIS_MODELS:
        raise ArgumentError("model", model, ", ".join(AXIS_MODELS), "choose one of these")


def read_scene_text_and_origin(scene: str) -> tuple[str, str]:
    """Return the text of a scene file, then its name in error messages; ``scene``: name of a shipped scene, or the file."""
    if scene in catalogue.scene_names():
        return catalogue.shipped_scene_text(scene), f"{scene}.toml"
    return scene_file.read_scene_text(scene), scene


#: Functions that compute outputs, by name of the output; only the functions of wanted outputs are called.
Makers = dict[str, Callable[[], Any]]


def outputs_of_scene(
    scene: Scene, result: StaticResult, model: str, options: ModelOptions, wanted_outputs: Collection[str]
) -> dict[str, Any]:
    """Return the outputs of a sweep's sample by name, and "at": ball and flank of the contact with the largest load.

    ``result``: converged static result of the scene; ``model`` and ``options``: name and options of the model that solved
    it; ``wanted_outputs``: names of the outputs, keys of `OUTPUTS`. Rigidity (secant from the unloaded position) and
    preload need a solution without loads, which is computed only for them. The torque needs a [friction] table in the
    scene. An output that does not exist for the scene is None.
    """

    @cache
    def unloaded_result() -> StaticResult:
        """Return the static result of the sample's scene with all external loads set to zero."""
        return loading.solve_with_scaled_loads(scene, 0.0, model, options)

    makers: Makers = {
        "displacement_um": lambda: _displacement_of_load_point(scene, result),
        "rigidity_N_per_um": lambda: _in_N_per_um(secant_of_nuts(scene, result, unloaded_result())),
        "preload_N": lambda: loading.axial_preload(scene, unloaded_result()) if unloaded_result().converged else None,
    }
    return _compute_wanted_outputs(
        [("", scene, result)], scene, makers, options, wanted_outputs, lambda: count_nominal_contacts(scene)
    )


def outputs_of_duty_cycle(
    cycle: DutyCycle,
    results: Sequence[StaticResult | AxisResult],
    outputs_by_case: Sequence[dict[str, Any]],
    *,
    wanted_outputs: Collection[str],
) -> dict[str, Any]:
    """Return the outputs of a sweep's sample for a duty cycle, from results and outputs of its load cases.

    Outputs are those of the load case with the largest contact load, which "at" names, with three exceptions. Life is
    the shortest life of a nut or bearing over the duty cycle. The friction torque is the mean over all revolutions of the
    cycle. Growth is the ratio of the largest contact or roller load of a nut or bearing in any load case to the largest in
    the first load case; the outputs are the largest and the smallest growth.

    Parameters
    ----------
    cycle
        The duty cycle.
    results
        Result of each load case.
    outputs_by_case
        Outputs of each load case by name.
    wanted_outputs
        Names of the outputs.

    Returns
    -------
    dict
        Values by name.
    """
    case, worst = max(zip(cycle.cases, outputs_by_case, strict=True), key=lambda pair: float(pair[1][MAIN]))
    compute_torques(outputs_by_case)
    found = worst | {"at": f"case {case.name}: {worst['at']}"}
    if "torque_Nmm" in wanted_outputs:
        pairs = zip(cycle.revolution_shares, (one["torque_Nmm"] for one in outputs_by_case), strict=True)
        torques = [(share, torque) for share, torque in pairs if share > 0.0]
        known = all(torque is not None for _, torque in torques)
        found["torque_Nmm"] = sum(share * torque for share, torque in torques) if known else None
    if "life_million_revolutions" in wanted_outputs:
        loads = [contact_loads_by_nut_or_bearing(one) for one in results]
        lives = [rating_life_over_duty_cycle(cycle, name, [of[name] for of in loads])[0] for name in cycle.sets]
        rated = [x.revolutions for x in lives if x is not None]
        found["life_million_revolutions"] = min(rated) if len(rated) == len(lives) else None
    if any(name in wanted_outputs for name in GROWTH):
        tops = [[float(load.max(initial=0.0)) for load in _loads_by_nut_or_bearing(one)] for one in results]
        ratios = [max(of_set) / of_set[0] for of_set in zip(*tops, strict=True) if of_set[0] > 0.0]
        ends = max(ratios, default=None), min(ratios, default=None)
        found |= {name: x for name, x in zip(GROWTH, ends, strict=True) if name in wanted_outputs}
    return found


def _loads_by_nut_or_bearing(result: StaticResult | AxisResult) -> list[Array]:
    """Return the loads of ball contacts or rollers of a result [N], as one array for each nut or bearing of the scene."""
    return [result.load] if isinstance(result, StaticResult) else [s.loads for s in result.sets]


def outputs_of_shaft(assembly: Assembly, result: AxisResult, wanted_outputs: Collection[str]) -> dict[str, Any]:
    """Return the outputs of a sweep's sample for a shaft with several nuts and bearings, by name.

    ``result``: converged static result; ``wanted_outputs``: names of the outputs, keys of `OUTPUTS`. Loads are those of
    ball contacts and rollers; "at", the contact with the largest load, begins with the name of the nut or bearing. The
    displacement is that of the load's point; the rigidity is the secant of the nuts together, or of the bearings where
    there is no nut. Hertz approaches and friction torque are of balls only, without rollers. Life is the shortest life of a
    nut or bearing; preload is the largest axial force on a nut or bearing without external loads.
    """
    sets = [(f"{s.of.name}: ", s.of.parts, s.balls) for s in result.sets if s.balls and isinstance(s.of.parts, Scene)]
    loads = contact_loads_by_nut_or_bearing(result)

    @cache
    def unloaded_result() -> AxisResult:
        """Return the static result of the shaft without external loads."""
        without = run_model(loading.with_scaled_loads(assembly, 0.0), result.model, ModelOptions())
        assert isinstance(without, AxisResult)
        return without

    def largest_preload() -> float | None:
        """Return the largest axial force on a nut or bearing without external loads [N]; None without equilibrium."""
        bare = unloaded_result()
        return max((abs(float(s.force[2])) for s in bare.sets), default=0.0) if bare.converged else None

    lives = [(s.of.parts, loads[s.of.name], turning_ring(assembly, s.of)) for s in result.sets]
    makers: Makers = {
        "displacement_um": lambda: _displacement_of_load_point(assembly, result),
        "rigidity_N_per_um": lambda: _in_N_per_um(secant_of_nuts(assembly, result, unloaded_result())),
        "preload_N": largest_preload,
        "life_million_revolutions": lambda: _shortest_life_of_bearings(lives),
    }
    rollers = [(f"{s.of.name}: roller ", s.loads) for s in result.sets if s.balls is None]
    return _compute_wanted_outputs(sets, assembly, makers, ModelOptions(), wanted_outputs, lambda: 0, rollers)


def _compute_wanted_outputs(
    ball_sets: list[tuple[str, Scene, StaticResult]],
    scene: Scene | Assembly,
    functions_of_whole_scene: Makers,
    options: ModelOptions,
    wanted_outputs: Collection[str],
    count_contacts: Callable[[], int],
    roller_loads: Sequence[tuple[str, Array]] = (),
) -> dict[str, Any]:
    """Return the outputs of a sweep's sample by name, and "at", the contact with the largest load of all nuts and bearings.

    Parameters
    ----------
    ball_sets
        Name, geometry and static result of each nut and ball bearing.
    scene
        Scene of a nut or bearing, or of a shaft with several.
    functions_of_whole_scene
        Functions without arguments that compute displacement [um], rigidity [N/um] and preload [N] of the whole scene, by
        name of the output.
    options
        Options of the model.
    wanted_outputs
        Names of the outputs.
    count_contacts
        Function that returns the number of contacts over which the mean load is taken, see `mean_load`.
    roller_loads
        Name of each row of rollers, and its loads [N].
    """
    solved, friction = [(parts, balls) for _, parts, balls in ball_sets], scene.friction
    named = [*((name, x.load) for name, _, x in ball_sets), *roller_loads]
    every = np.concatenate([np.zeros(0), *(load[load > 0.0] for _, load in named)])
    at = ""
    if every.size:
        name, load = max(named, key=lambda one: float(one[1].max(initial=0.0)))
        one, *side = np.unravel_index(int(load.argmax()), load.shape)
        at = " ".join([f"{name}{one + 1}", *(SIDES[k] for k in side)])

    def friction_torque() -> UnsolvedTorque | None:
        """Return what `compute_torques` computes the friction torque from; None without friction."""
        from rollbench.compare.models.friction_sums import UnsolvedTorque

        return None if friction is None else UnsolvedTorque(solved, friction, scene.motion, options.member)

    makers: Makers = {
        MAIN: lambda: float(every.max(initial=0.0)),
        "mean_load_N": lambda: mean_load(every, count_contacts()),
        "loaded_contacts": lambda: int(every.size),
        "idle_balls": lambda: sum(int(np.count_nonzero(~(x.load > 0.0).any(axis=1))) for _, x in solved),
        "largest_approach_um": lambda: max((_largest_hertz_approach(balls) for _, balls in solved), default=None),
        "torque_Nmm": friction_torque,
        "life_million_revolutions": lambda: _shortest_life_of_bearings(
            [(parts, balls.load, turning_ring(scene)) for parts, balls in solved]
        ),
        **dict.fromkeys(GROWTH, lambda: None),
        **functions_of_whole_scene,
    }
    return {name: makers[name]() for name in OUTPUTS if name == MAIN or name in wanted_outputs} | {"at": at}


def compute_torques(outputs: Sequence[dict[str, Any]]) -> None:
    """Replace the friction torques that are not computed yet by numbers [N mm], all together; None without convergence.

    ``outputs``: outputs of samples or load cases by name.
    """
    asked = [one for one in outputs if one.get("torque_Nmm") is not None]
    if not asked:
        return
    from rollbench.compare.models.friction_sums import UnsolvedTorque, total_friction_torques

    unsolved = [one for one in asked if isinstance(one["torque_Nmm"], UnsolvedTorque)]
    torques = total_friction_torques([one["torque_Nmm"] for one in unsolved])
    for one, torque in zip(unsolved, torques, strict=True):
        one["torque_Nmm"] = torque


def _displacement_of_load_point(scene: Scene | Assembly, result: StaticResult | AxisResult) -> float | None:
    """Return the displacement of the load's point to ground, from its nominal position [um]; None if not known."""
    point = load_point(scene)
    moved = np.nan if point is None else 1e6 * displacement_of_load_point(result, point)
    return None if np.isnan(moved) else moved


def _largest_hertz_approach(balls: StaticResult) -> float:
    """Return the largest Hertz approach of a ball contact [um]; ``balls``: static result of a nut or ball bearing."""
    return 1e6 * float((balls.hertz_C * np.cbrt(balls.load) ** 2).max(initial=0.0))


def _in_N_per_um(stiffness: float | None) -> float | None:
    """Return a stiffness [N/m] in N/um; None if it is not known."""
    return None if stiffness is None else 1e-6 * stiffness


def _shortest_life_of_bearings(sets: list[tuple[Scene | RollerRow, Array, TurningRing]]) -> float | None:
    """Return the shortest life of several nuts (L10) and bearings (L10r) by their contact loads [10^6 revolutions].

    ``sets``: geometry of each nut or bearing, its contact loads [N] or line loads [N/m], and the ring that turns. The
    result is None if no nut or bearing is loaded, or if a load rating is outside its range of validity.
    """
    try:
        found = [
            roller_reference_life(x, load, ring) if isinstance(x, RollerRow) else basic_rating_life(x, load, ring)
            for x, load, ring in sets
        ]
    except ValueError:
        return None
    return min((one.revolutions for one in found if one is not None), default=None)


#: Pattern of the numbers in a reason for which values are refused.
_NUMBER = re.compile(r"[0-9][0-9.]*(e[+-]?[0-9]+)?")


def solve_sample(
    varied: VariedScene,
    values: Sequence[Any],
    model: str,
    wanted_outputs: Collection[str] = tuple(OUTPUTS),
    *,
    torques: bool = True,
) -> dict[str, Any]:
    """Solve one sample of a sweep; return its status and, if it is solved, its outputs by name.

    ``values``: values of the varied keys in this sample; ``model``: name of the model; ``wanted_outputs``: names of the
    outputs, keys of `OUTPUTS`; ``torques``: False to leave the friction torque to `compute_torques`, which is faster for
    several samples at once. If the scene or the model does not allow the values, status and "reason" say why.
    """
    try:
        found = solve_sample_or_refuse(varied, values, model, wanted_outputs)
    except InputError as error:
        found = {"status": f"refused: {error}", "reason": refusal_reason_without_numbers(error)}
    if torques:
        compute_torques([found])
    return found


def solve_sample_or_refuse(
    varied: VariedScene, values: Sequence[Any], model: str, wanted_outputs: Collection[str], origin: str = ""
) -> dict[str, Any]:
    """Solve one sample of a sweep; return its status and its outputs by name.

    The arguments are those of `solve_sample` and of `VariedScene.at`; friction torques are left to `compute_torques`.
    Raises InputError if the scene or the model does not allow the sample's values.
    """
    scene = varied.at(values, origin)
    if isinstance(scene, DutyCycle):
        return _solve_duty_cycle_sample(scene, model, wanted_outputs)
    one = scene_file.scene_or_shaft_or_raise(scene, origin or varied.file_name)
    result, kept = solve_load_case_for_outputs(one, model, wanted_outputs)
    return {"status": result.status, **kept}


def refusal_reason_without_numbers(error: InputError) -> str:
    """Return why a sample's key values are refused, as text in which "#" replaces each number.

    Reasons that differ only in numbers, such as a range that depends on the sample, thus become equal. ``error``: error
    that the refused values raised.
    """
    return _NUMBER.sub("#", f"{error.key}: {error.allowed or error.value}")


def _solve_duty_cycle_sample(cycle: DutyCycle, model: str, wanted_outputs: Collection[str]) -> dict[str, Any]:
    """Solve the load cases of a duty cycle; return the status and the outputs of the cycle by name.

    ``wanted_outputs``: names of the outputs. If a load case has no solution, only the status of that case is returned.
    """
    solved = [solve_load_case_for_outputs(case.scene, model, wanted_outputs) for case in cycle.cases]
    for case, (result, _) in zip(cycle.cases, solved, strict=True):
        if not result.converged:
            return {"status": f"case {case.name}: {result.status}"}
    return {"status": CONVERGED, **outputs_of_duty_cycle(cycle, *zip(*solved, strict=True), wanted_outputs=wanted_outputs)}


def solve_load_case_for_outputs(
    scene: Scene | Assembly, model: str, wanted_outputs: Collection[str]
) -> tuple[StaticResult | AxisResult, dict[str, Any]]:
    """Solve one load case of a sweep's sample: return its static result, then its outputs by name (empty without solution).

    ``wanted_outputs``: names of the outputs. Friction torques are left to `compute_torques`.
    """
    if isinstance(scene, Assembly):
        found = run_model(scene, model, ModelOptions())
        return found, outputs_of_shaft(scene, found, wanted_outputs) if found.converged else {}
    options = ModelOptions(estimate_beam_mesh_error=False)
    result = run_model(scene, model, options)
    return result, outputs_of_scene(scene, result, model, options, wanted_outputs) if result.converged else {}


def solve_numbered_sample(
    varied: VariedScene, model: str, wanted_outputs: Collection[str], number: int, values: list[Any]
) -> Record:
    """Solve one sample of a sweep as `solve_sample`, without friction torques; return its record with its ``number``."""
    found = solve_sample(varied, values, model, wanted_outputs, torques=False)
    return {"sample": number, "values": values, **found}


def stored_records_by_sample(folder: Path) -> dict[int, Record]:
    """Return the stored records of a sweep's samples by the number of the sample, from 0."""
    return {int(record["sample"]): record for record in stored_records(folder)}
