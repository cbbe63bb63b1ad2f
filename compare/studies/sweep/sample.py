"""Samples of a sweep: the scene with other values, its solution, and its columns."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.models.many import CONVERGED, Record
from rollbench.compare.models.registry import AXIS_MODELS, model_by_name
from rollbench.compare.scenes import scene_file, scene_tables
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.studies import columns
from rollbench.compare.studies.sweep.keys import VariedKey, tables_with_varied_keys, varied_and_replaced_keys
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


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

    @cached_property
    def tables(self) -> dict[str, Any]:
        """TOML tables of the scene file, which must not be changed."""
        return scene_file.parse_toml(self.text, self.origin)

    def check_keys(self) -> None:
        """Raise InputError if the scene does not allow a value of a key."""
        for vary in self.keys:
            for value in vary.trial_values:
                scene_tables.validated_keys(tables_with_varied_keys(self.tables, [vary], [value]), self.origin)

    def say_which_keys_are_replaced(self, show_progress: Callable[[str], None]) -> None:
        """Show a line for each key of the scene that a varied key replaces."""
        for path, other in varied_and_replaced_keys(self.tables, self.keys):
            show_progress(f"{path} replaces {other} of the scene")

    def at(self, values: Sequence[Any], origin: str = "") -> Described:
        """Return the scene with a value of each varied key; InputError if it does not allow them.

        ``origin``: name of the scene file in errors; if empty, `file_name`.
        """
        tables = tables_with_varied_keys(self.tables, self.keys, values)
        return scene_tables.scene_from_tables(tables, origin or self.file_name)


def check_model(scene: Described, model: str) -> None:
    """Raise InputError if the model is unknown, or does not cover the scene."""
    if not isinstance(scene, Assembly):
        model_by_name(model, excluded_names=("condensed",))
    elif model not in AXIS_MODELS:
        raise ArgumentError("model", model, ", ".join(AXIS_MODELS), "choose one of these")


#: Pattern of the numbers in a reason for which values are refused.
_NUMBER = re.compile(r"[0-9][0-9.]*(e[+-]?[0-9]+)?")


def solve_samples(
    varied: VariedScene, samples: Sequence[Sequence[Any]], model: str, wanted: Collection[str] = tuple(columns.COLUMNS)
) -> list[Record]:
    """Solve samples of a sweep together; return the status of each and, if it is solved, its outputs by name.

    ``samples``: values of the varied keys in each sample; ``model``: name of the model; ``wanted``: names of the columns,
    keys of `COLUMNS`. If the scene or the model does not allow the values, status and "reason" say why. A result depends on
    the other samples by round-off.
    """
    found = [
        {"status": f"refused: {one}", "reason": refusal_reason_without_numbers(one)} if isinstance(one, InputError) else one
        for one in rows_of_samples(varied, samples, model, wanted)
    ]
    columns.compute_torques(found)
    return found


def rows_of_samples(
    varied: VariedScene, samples: Sequence[Sequence[Any]], model: str, wanted: Collection[str], origin: str = ""
) -> list[Record | InputError]:
    """Solve samples of a sweep together; return the status of each and its outputs by name, or the error that refuses it.

    The arguments are those of `solve_samples` and of `VariedScene.at`; friction torques are left to `compute_torques`.
    """
    described = [_scene_of_sample(varied, values, origin) for values in samples]
    cases = [[] if isinstance(x, InputError) else _load_cases(x) for x in described]
    solved = iter(columns.rows_of_scenes([scene for each in cases for scene in each], model, wanted))
    rows: list[Record | InputError] = []
    for one, each in zip(described, cases, strict=True):
        of_cases = [next(solved) for _ in each]
        refused = [x for x in (one, *of_cases) if isinstance(x, InputError)]
        accepted = [x for x in of_cases if not isinstance(x, InputError)]
        if refused:
            rows.append(refused[0])
        elif isinstance(one, DutyCycle):
            rows.append(_row_of_duty_cycle(one, accepted, wanted))
        else:
            rows.append({"status": accepted[0][0].result.status, **accepted[0][1]})
    return rows


def _scene_of_sample(varied: VariedScene, values: Sequence[Any], origin: str) -> Scene | Assembly | DutyCycle | InputError:
    """Return the scene of a sample, or the error that refuses it; arguments of `VariedScene.at`."""
    try:
        scene = varied.at(values, origin)
        return (
            scene if isinstance(scene, DutyCycle) else scene_file.scene_or_shaft_or_raise(scene, origin or varied.file_name)
        )
    except InputError as error:
        return error


def _load_cases(scene: Scene | Assembly | DutyCycle) -> list[Scene | Assembly]:
    """Return the load cases of a sample, each as a scene."""
    return [case.scene for case in scene.cases] if isinstance(scene, DutyCycle) else [scene]


def refusal_reason_without_numbers(error: InputError) -> str:
    """Return why a sample's key values are refused, as text in which "#" replaces each number.

    Reasons that differ only in numbers, such as a range that depends on the sample, thus become equal. ``error``: error
    that the refused values raised.
    """
    return _NUMBER.sub("#", f"{error.key}: {error.allowed or error.value}")


def _row_of_duty_cycle(
    cycle: DutyCycle, cases: Sequence[tuple[columns.SolvedScene, Record]], wanted: Collection[str]
) -> Record:
    """Return the status and the columns of a duty cycle by name from its solved load cases and their columns.

    ``wanted``: names of the columns. If a load case has no solution, only the status of that case is returned.
    """
    solved, rows = zip(*cases, strict=True)
    for case, one in zip(cycle.cases, solved, strict=True):
        if not one.result.converged:
            return {"status": f"case {case.name}: {one.result.status}"}
    return {"status": CONVERGED, **columns.row_of_duty_cycle(cycle, solved, rows, wanted)}


def records_of_samples(
    varied: VariedScene, model: str, wanted: Collection[str], numbers: Sequence[int], values: Sequence[list[Any]]
) -> list[Record]:
    """Solve the samples of a batch as `solve_samples`, and return their records with number and values of each.

    ``numbers``: numbers of the samples; ``values``: values of the varied keys in each.
    """
    found = zip(numbers, values, solve_samples(varied, values, model, wanted), strict=True)
    return [{"sample": number, "values": at, **record} for number, at, record in found]
