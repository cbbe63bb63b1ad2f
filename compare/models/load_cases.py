"""A scene solved with all its answers, the load cases of a duty cycle one after the other, and what they say together."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rollbench.compare.models.answers import Answers, AxisAnswers, LoadAnswers, RollerAnswers, gather, outside, solve_sets
from rollbench.compare.models.load_path import path_warnings
from rollbench.compare.models.loading import axial_of
from rollbench.compare.models.model_form import ModelForm, estimate
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.ring_play import play_warnings
from rollbench.lowfi.rating.overall_friction import overall_warnings
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Load, Scene


@dataclass(frozen=True)
class OfSet:
    """What a solved scene says of one set of balls for a duty cycle. parts: with the loads and supports of the scene; load:
    of its contacts ``(n, 4)`` [N]; force: of the shaft on it ``(3,)`` [N]; preload: axial force [N] between two halves with
    a lead offset."""

    parts: Scene
    load: Array
    force: Array
    answers: LoadAnswers
    preload: float = 0.0


@dataclass(frozen=True)
class Solved:
    """A scene by one model: its result with all warnings; answers, and the error to expect of it, where it converged."""

    scene: Scene
    result: StaticResult
    answers: Answers | None = None
    expected: ModelForm | None = None

    @property
    def contacts(self) -> tuple[LoadAnswers, ...]:
        """What its contact loads answer; nothing where it did not converge."""
        return () if self.answers is None else (self.answers.loads,)

    @property
    def sets(self) -> dict[str, OfSet]:
        """Its one set, without a name; none where it did not converge."""
        if self.answers is None or self.result.equilibrium is None:
            return {}
        preload = axial_of(self.answers.preload) if self.scene.errors.lead_offset else 0.0
        force = -self.result.equilibrium.contact_force
        return {"": OfSet(self.scene, self.result.load, force, self.answers.loads, preload)}


@dataclass(frozen=True)
class SolvedAxis:
    """Several sets on one shaft by one model, in the words of `Solved`; no error to expect is known of them."""

    scene: Assembly
    result: AxisResult
    answers: AxisAnswers | None = None
    expected: None = None

    @property
    def contacts(self) -> tuple[LoadAnswers | RollerAnswers, ...]:
        """What the contact loads of each set answer, of rollers too; nothing where it did not converge."""
        return () if self.answers is None else tuple(x.loads for x in self.answers.sets)

    @property
    def sets(self) -> dict[str, OfSet]:
        """Its sets of balls by name; none where it did not converge."""
        if self.answers is None:
            return {}
        on_housings = (Load(h.at, h.force, h.moment) for h in self.scene.housings)
        loads, out = (*self.scene.loads, *on_housings), {}
        for s, answers in zip(self.result.sets, self.answers.sets, strict=True):
            if isinstance(answers.parts, Scene) and isinstance(answers.loads, LoadAnswers) and s.balls is not None:
                parts = replace(answers.parts, name=self.scene.name, loads=loads, supports=self.scene.supports)
                out[s.of.name] = OfSet(parts, s.balls.load, -s.force, answers.loads)
        return out


def solve_any(scene: Scene | Assembly, model: str, options: Options) -> Solved | SolvedAxis:
    """Solve a scene of one set or several and gather all answers. Raises InputError and Refusal as `run_model`."""
    return solve_axis(scene, model, options) if isinstance(scene, Assembly) else solve_one(scene, model, options)


def solve_axis(scene: Assembly, model: str, options: Options) -> SolvedAxis:
    """Solve several sets and gather all answers. Raises InputError as `run_model`."""
    return SolvedAxis(scene, *solve_sets(scene, model, options.member))


def solve_one(scene: Scene, model: str, options: Options) -> Solved:
    """Solve a scene and gather all answers. Raises InputError and Refusal as `run_model`."""
    result = run_model(scene, model, options)
    if not result.converged:
        return Solved(scene, result)
    answers = gather(scene, result, model, options)
    warned = [*outside(scene, answers.loads, axial_of(answers.preload))]
    if scene.friction is not None:
        warned += overall_warnings(scene.track, scene.friction)
    warned += [*path_warnings(answers.path), *play_warnings(scene)]
    result = replace(result, warnings=(*result.warnings, *warned))
    return Solved(scene, result, answers, estimate(scene, result))
