"""Samples of a sweep: the scene with other values, its solution, its outputs, and the folder that stores them.

The folder has a file that states the sweep, and files with one line per sample, which is appended when its batch is solved
and never changed. Every process writes to a separate file, the lines of a batch in one call and each with a checksum.
Whenever a process is killed, finished batches are therefore complete, and a torn line is recognised.

Each run of the sweep writes a token (random text) into the folder. A process that outlives its run stops after its batch,
because the token in the folder is no longer that of its run. A new run waits, by a lock that each process holds while it
solves, until such processes have stopped; only then does it read the folder, so that no sample is solved twice.
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from functools import cache, lru_cache
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.files import replace_file
from rollbench.compare.measure import mean_load
from rollbench.compare.models import loading
from rollbench.compare.models.load_cases import contact_loads_by_nut_or_bearing, rating_life_over_duty_cycle
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.models.stiffness import secant_of_nuts
from rollbench.compare.scenes import scene_file, scene_tables
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.studies.sweep.keys import VariedKey, tables_with_varied_keys
from rollbench.lowfi.rating.displacement import displacement_of_load_point, load_point
from rollbench.lowfi.rating.iso_lives import roller_reference_life
from rollbench.lowfi.rating.life import TurningRing, basic_rating_life, turning_ring
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.files import machine_code
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


#: Names of files and folders in the folder of a sweep.
HEADER, TOKEN, LOCKS, RECORDS = "sweep.json", "token", "locks", "records"

#: Longest time to wait for processes of an earlier run [s].
PATIENCE = 600.0

Record = dict[str, Any]


def create_or_check_sweep_folder(folder: Path, header: Mapping[str, Any]) -> None:
    """Create the folder that stores a sweep, or check that an existing folder belongs to this sweep.

    ``header``: JSON values that identify the sweep, such as its scene and keys; they are written to a file of the folder.
    Raises InputError if the folder holds other files or another sweep.
    """
    path = folder / HEADER
    text = json.dumps(header, indent=1, ensure_ascii=False) + "\n"
    allowed, advice = "a new folder, or that of this sweep", "choose another folder for another sweep"
    if path.exists():
        if path.read_text(encoding="utf-8") != text:
            raise ArgumentError("out", "the folder of another sweep", allowed, advice, str(folder))
    else:
        if folder.exists() and any(folder.iterdir()):
            raise ArgumentError("out", "a folder with other files", allowed, advice, str(folder))
        replace_file(path, text)
    (folder / RECORDS).mkdir(exist_ok=True)
    (folder / LOCKS).mkdir(exist_ok=True)


@contextmanager
def reserve_sweep_folder(folder: Path) -> Iterator[str]:
    """Reserve the folder of a sweep for the present execution, and yield a text (token) that identifies the execution.

    First wait until no process of an earlier execution of the sweep writes to the folder. Raises InputError if another
    execution is active there.
    """
    from filelock import FileLock, Timeout

    with ExitStack() as held:
        try:
            held.enter_context(FileLock(folder / "run", timeout=0))
        except Timeout:
            given, allowed = "the folder of a sweep that is running", "a folder in which no run is active"
            raise ArgumentError("out", given, allowed, "wait for that run, or end it", str(folder)) from None
        token = uuid4().hex
        replace_file(folder / TOKEN, token)
        _wait_for_earlier_runs(folder)
        yield token


def _wait_for_earlier_runs(folder: Path) -> None:
    """Wait until the processes of earlier executions of a sweep have finished their batches, and remove their lock files.

    ``folder``: folder of the sweep. Raises InputError if the processes take longer than `PATIENCE` seconds.
    """
    from filelock import FileLock, Timeout

    until = monotonic() + PATIENCE
    for path in (folder / LOCKS).iterdir():
        try:
            with FileLock(path, timeout=max(until - monotonic(), 0.0), poll_interval=0.02):
                path.unlink(missing_ok=True)
        except Timeout:
            given = "a folder to which processes of an earlier run of the sweep still write"
            allowed, advice = "a folder to which no other process writes", "end the processes of the earlier run"
            raise ArgumentError("out", given, allowed, advice, str(folder)) from None


@contextmanager
def hold_process_lock(folder: Path) -> Iterator[None]:
    """Hold a lock file of this process in the folder of a sweep while the process solves samples.

    A later execution of the sweep waits until the lock is released.
    """
    from filelock import FileLock

    with FileLock(folder / LOCKS / _machine_and_process_name()):
        yield


def _machine_and_process_name() -> str:
    """Return digits for this machine and the number of this process, by which files of a sweep are named."""
    return f"{machine_code()}-{os.getpid()}"


def is_token_of_current_run(folder: Path, token: str) -> bool:
    """Return whether the folder of a sweep exists and is reserved for the execution that ``token`` identifies."""
    try:
        return (folder / TOKEN).read_text(encoding="utf-8") == token
    except OSError:
        return False


class RecordWriter:
    """Writer that appends records of solved samples to a file in a sweep's folder; no other process writes this file."""

    def __init__(self, folder: Path, token: str) -> None:
        """Choose the name of the file, which is opened when the first record is appended.

        ``folder``: folder of the sweep; ``token``: text that identifies the execution of the sweep.
        """
        self._path = folder / RECORDS / f"{token[:8]}-{_machine_and_process_name()}.lines"

    def append(self, records: Sequence[Record]) -> None:
        """Append records of samples to the file in one call; OSError if the disk does not take all of the records."""
        lines = b"".join(map(record_as_checked_line, records))
        handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o644)
        try:
            if os.write(handle, lines) != len(lines):
                raise OSError(28, "the disk is full: the records of samples were not written completely", str(self._path))
        finally:
            os.close(handle)


def record_as_checked_line(record: Record) -> bytes:
    """Return the record of a sample as one line: a checksum, then JSON."""
    body = json.dumps(record, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    return b"%08x %s\n" % (zlib.crc32(body), body)


def record_from_checked_line(line: bytes) -> Record | None:
    """Return the record of a sample from a line with checksum and JSON; None if the line is incomplete or damaged."""
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(body):
        return None
    found: Record = json.loads(body)
    return found


def stored_sample_records(folder: Path) -> Iterator[Record]:
    """Yield all undamaged records of samples in the folder of a sweep, file by file."""
    for path in sorted((folder / RECORDS).glob("*.lines")):
        with path.open("rb") as file:
            for line in file:
                record = record_from_checked_line(line)
                if record is not None:
                    yield record


def stored_records_by_sample(folder: Path) -> dict[int, Record]:
    """Return the stored records of a sweep's samples by the number of the sample, from 0."""
    return {int(record["sample"]): record for record in stored_sample_records(folder)}


#: Status of a solved sample.
CONVERGED = "converged"

#: Pattern of the numbers in a reason for which values are refused.
_NUMBER = re.compile(r"[0-9][0-9.]*(e[+-]?[0-9]+)?")


@lru_cache(maxsize=8)
def _cached_toml_tables(text: str, origin: str) -> dict[str, Any]:
    """Return the TOML tables in the text of a scene file; equal texts are read only once.

    ``origin``: name of the file for error messages.
    """
    return scene_file.parse_toml(text, origin)


def solve_sample(
    scene_text: str,
    origin: str,
    varied_keys: Sequence[VariedKey],
    values: Sequence[Any],
    model: str,
    wanted_outputs: Collection[str] = tuple(OUTPUTS),
    *,
    torques: bool = True,
) -> dict[str, Any]:
    """Solve one sample of a sweep; return its status and, if it is solved, its outputs by name.

    ``scene_text``: TOML text of the scene file; ``origin``: name of that file for error messages; ``varied_keys``: varied
    keys; ``values``: their values in this sample; ``model``: name of the model; ``wanted_outputs``: names of the outputs,
    keys of `OUTPUTS`; ``torques``: False to leave the friction torque to `compute_torques`, which is faster for several
    samples at once. If the scene or the model does not allow the values, status and "reason" say why.
    """
    try:
        found = solve_sample_or_refuse(scene_text, origin, varied_keys, values, model, wanted_outputs)
    except InputError as error:
        found = {"status": f"refused: {error}", "reason": refusal_reason_without_numbers(error)}
    if torques:
        compute_torques([found])
    return found


def solve_sample_or_refuse(
    scene_text: str,
    origin: str,
    varied_keys: Sequence[VariedKey],
    values: Sequence[Any],
    model: str,
    wanted_outputs: Collection[str],
) -> dict[str, Any]:
    """Solve one sample of a sweep; return its status and its outputs by name.

    The arguments are those of `solve_sample`; friction torques are left to `compute_torques`. Raises InputError if the
    scene or the model does not allow the sample's values.
    """
    tables = tables_with_varied_keys(_cached_toml_tables(scene_text, origin), varied_keys, values)
    scene = scene_tables.scene_from_tables(tables, origin)
    if isinstance(scene, DutyCycle):
        return _solve_duty_cycle_sample(scene, model, wanted_outputs)
    one = scene_file.scene_or_shaft_or_raise(scene, origin)
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


def solve_and_append_batch(
    folder: str,
    token: str,
    sweep: tuple[str, str, tuple[VariedKey, ...], str, tuple[str, ...]],
    batch: list[tuple[int, list[Any]]],
) -> tuple[list[Record], bool]:
    """Solve a batch of samples; return their records, and whether they were already appended to the folder of the sweep.

    A worker process that does not see the folder, or whose execution of the sweep is over, does not write there and only
    returns the records.

    Parameters
    ----------
    folder
        Folder of the sweep.
    token
        Text that identifies the execution of the sweep, as `reserve_sweep_folder` yields it.
    sweep
        TOML text of the scene file, name of that file, varied keys, name of the model, and names of the wanted
        outputs.
    batch
        For each sample its number, and its values of the varied keys.
    """
    run_folder = Path(folder)
    text, origin, keys, model, wanted = sweep
    here = is_token_of_current_run(run_folder, token)
    found: list[Record] = []
    with hold_process_lock(run_folder) if here else nullcontext():
        try:
            for number, values in batch:
                solved = solve_sample(text, origin, keys, values, model, wanted, torques=False)
                found.append({"sample": number, "values": values, **solved})
        finally:  # of an interrupted batch too
            compute_torques(found)
            if here and found:
                RecordWriter(run_folder, token).append(found)
    return found, here
