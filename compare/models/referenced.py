"""What stands beside a 3D reference: a scene of one set, or each set of several on one shaft, with the loads that a model
finds for it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from time import perf_counter

import numpy as np

from rollbench.compare.models.loading import scaled
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.reference.estimate import FITTED, Reference, reference_of
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load
from rollbench.compare.reference.tasks import Solvable, balls_of
from rollbench.lowfi.statics.nominal import nominal, nominal_contacts
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Load, Scene


@dataclass(frozen=True)
class SetOf:
    """A set of several on one shaft: its number, from 0."""

    assembly: Assembly
    number: int

    @property
    def name(self) -> str:
        """Name of the set."""
        return self.assembly.sets[self.number].name

    @property
    def scene(self) -> Scene:
        """Its parts as a scene under the name of both. Raises ValueError for rollers."""
        parts = self.assembly.sets[self.number].parts
        if not isinstance(parts, Scene):
            raise ValueError(f"{self.name} has no balls")
        return replace(parts, name=re.sub(r"[^\w.-]+", "-", f"{self.assembly.name}-{self.name}"))

    @property
    def contacts(self) -> int:
        """How many contacts the nominal set loads."""
        return _contacts(self.assembly)[self.number]


@dataclass(frozen=True)
class Referenced:
    """A scene and its 3D reference; of one of several sets on a shaft its parts as a scene, and which set it is."""

    scene: Scene
    found: Reference
    of: SetOf | None = None

    @property
    def described(self) -> str:
        """Name of the scene that it is of, or that its set is of."""
        return self.scene.name if self.of is None else self.of.assembly.name

    @property
    def set(self) -> str:
        """Name of the set, empty where it is the only one."""
        return "" if self.of is None else self.of.name


@dataclass(frozen=True)
class Answered:
    """What a model finds for a set: its contacts under the loads of the assembly, and without them; seconds of the first
    solution; the set as a scene of one set under the force and moment that its balls carry."""

    result: StaticResult
    bare: StaticResult
    seconds: float
    scene: Scene


def referenced(
    described: Solvable, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS), fitted: int = FITTED
) -> list[Referenced]:
    """The best stored reference of a scene, by the ``fitted`` finest runs on some levels, set by set; none without any."""
    runs = tuple(run for level in levels if (run := load(described, level, stores=stores)) is not None)
    return referenced_by(described, runs[-fitted:]) if runs else []


def referenced_by(described: Solvable, runs: tuple[Run, ...]) -> list[Referenced]:
    """The reference of runs, coarse to fine, set by set."""
    if isinstance(described, Scene):
        return [Referenced(described, reference_of(described.name, described, runs, contacts=nominal_contacts(described)))]
    out = []
    for k, rows in enumerate(balls_of(described)):
        of = SetOf(described, k)
        of_set = tuple(replace(r, load=r.load[rows], angle=r.angle[rows], frozen=r.frozen[rows]) for r in runs)
        reference = reference_of(f"{described.name}, {of.name}", of.scene, of_set, contacts=of.contacts)
        out.append(Referenced(of.scene, reference, of))
    return out


@lru_cache(maxsize=64)
def _contacts(assembly: Assembly) -> tuple[int, ...]:
    """Contacts that each nominal set loads (`nominal_contacts`): without errors but for preloads, by the model lin."""
    sets = tuple(replace(s, parts=nominal(s.parts)) if isinstance(s.parts, Scene) else s for s in assembly.sets)
    result = run_model(replace(assembly, sets=sets), "lin")
    return tuple(_loaded(result, k) for k in range(len(sets)))


def _loaded(result: AxisResult, k: int) -> int:
    balls = result.sets[k].balls if result.converged else None
    return 0 if balls is None else int(np.count_nonzero(balls.load > 0.0))


@lru_cache(maxsize=16)
def _solved(assembly: Assembly, model: str) -> tuple[AxisResult, AxisResult, float]:
    start = perf_counter()
    result = run_model(assembly, model, Options(engine="interpreted"))
    seconds = perf_counter() - start
    return result, run_model(scaled(assembly, 0.0), model, Options(engine="interpreted")), seconds


def answered(of: SetOf, model: str) -> Answered | str:
    """What a model finds for a set; why the assembly has no loads by it, where it does not converge.

    Raises InputError for a model that describes one set only.
    """
    result, bare, seconds = _solved(of.assembly, model)
    if not result.converged:
        return result.status
    loaded, idle = result.sets[of.number], bare.sets[of.number] if bare.converged else None
    assert loaded.balls is not None
    assert isinstance(loaded.of.parts, Scene)
    balls = replace(loaded.balls, model=model)
    carried = Load(loaded.of.position, tuple(-x for x in loaded.force), tuple(-x for x in loaded.moment))
    without = balls.without_answers() if idle is None or idle.balls is None else idle.balls
    return Answered(balls, replace(without, model=model), seconds, replace(loaded.of.parts, loads=(carried,)))
