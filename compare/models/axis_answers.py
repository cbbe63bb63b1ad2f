"""What an engineer asks of several rolling sets on one shaft: contacts, preload, safety, life of each."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rollbench.comparison.models.answers import LoadAnswers, load_answers
from rollbench.comparison.models.loading import Preload, along_axis, axial_load, axial_of, scaled
from rollbench.comparison.models.outside import outside
from rollbench.comparison.models.registry import Options, run_model
from rollbench.lowfi.statics.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class SetAnswers:
    """One set of balls: its name and parts. preload: of its contacts without the loads of the scene, axially the force that
    it then has on the shaft; None where the scene does not solve then."""

    name: str
    parts: Scene
    loads: LoadAnswers
    preload: Preload | None


@dataclass(frozen=True)
class AxisAnswers:
    """sets: of each, None for rollers; force [N]: axial loads on shaft and housings; displacement [m]: of what is asked
    about, along the axis, from that without loads."""

    sets: tuple[SetAnswers | None, ...]
    force: float
    displacement: float | None


def gather(assembly: Assembly, result: AxisResult) -> AxisAnswers:
    """Answers of a converged result, with the further solution without loads."""
    bare = run_model(scaled(assembly, 0.0), result.model, Options(member=result.member))
    sets = tuple(_of_set(s, bare.sets[i] if bare.converged else None) for i, s in enumerate(result.sets))
    moved = along_axis(assembly, result) - along_axis(assembly, bare) if bare.converged else None
    return AxisAnswers(sets, axial_load(assembly), moved)


def solve_sets(assembly: Assembly, model: str, member: int = 0) -> tuple[AxisResult, AxisAnswers | None]:
    """The result with all warnings, and its answers where it converged. Raises InputError and Refusal as `run_model`."""
    result = run_model(assembly, model, Options(member=member))
    if not result.converged:
        return result, None
    answers = gather(assembly, result)
    sets = (x for x in answers.sets if x is not None)
    warned = (w.of(x.name) for x in sets for w in outside(x.parts, x.loads, axial_of(x.preload)))
    return replace(result, warnings=(*result.warnings, *warned)), answers


def _of_set(s: SetResult, bare: SetResult | None) -> SetAnswers | None:
    if s.balls is None or not isinstance(s.of.parts, Scene):
        return None
    answers = load_answers(s.of.parts, s.balls.load, s.balls.contact_angle)
    if bare is None or bare.balls is None:
        return SetAnswers(s.of.name, s.of.parts, answers, None)
    loads = bare.balls.load[bare.balls.load > 0.0]
    mean = mean_load(loads) if loads.size else 0.0
    preload = Preload(mean, float(loads.max(initial=0.0)), int(loads.size), float(bare.force[2]))
    return SetAnswers(s.of.name, s.of.parts, answers, preload)
