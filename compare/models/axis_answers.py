"""What an engineer asks of several rolling sets on one shaft: contacts, preload, safety, life of each; its load curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.comparison.models.answers import LoadAnswers, load_answers
from rollbench.comparison.models.axis import run_axis
from rollbench.lowfi.statics.axis.result import AxisResult, SetResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import Load, Scene


@dataclass(frozen=True)
class SetAnswers:
    """One set of balls. preload: mean and largest load [N] of its loaded contacts without the loads of the scene, how many
    they are, and the force [N] along the axis that it then has on the shaft; None where the scene does not solve then."""

    loads: LoadAnswers
    preload: tuple[float, float, int, float] | None


@dataclass(frozen=True)
class AxisAnswers:
    """sets: of each, None for rollers; force [N]: axial loads on shaft and housings; displacement [m]: of what is asked
    about, along the axis, from that without loads."""

    sets: tuple[SetAnswers | None, ...]
    force: float
    displacement: float | None


@dataclass(frozen=True)
class AxisPoint:
    """An assembly at a factor on its loads: axial force [N] and displacement [m] as in `AxisAnswers`, tangent stiffness
    along the axis [N/m] (nan where it is held), largest load of a ball or roller [N]."""

    factor: float
    force: float
    displacement: float
    stiffness: float
    largest: float


def scaled(assembly: Assembly, factor: float) -> Assembly:
    """The assembly with the loads on shaft and housings times a factor."""

    def times(v: tuple[float, float, float]) -> tuple[float, float, float]:
        return factor * v[0], factor * v[1], factor * v[2]

    housings = tuple(replace(h, force=times(h.force), moment=times(h.moment)) for h in assembly.housings)
    loads = tuple(Load(x.at, times(x.force), times(x.moment)) for x in assembly.loads)
    return replace(assembly, loads=loads, housings=housings, stiffness_at=asked(assembly))


def asked(assembly: Assembly) -> float | str:
    """Station [m] or housing whose motion and stiffness are asked for: as the assembly says, else the first housing that is
    loaded, the first load, the first set."""
    if assembly.stiffness_at is not None:
        return assembly.stiffness_at
    loaded = [h.name for h in assembly.housings if any(h.force) or any(h.moment)]
    if loaded:
        return loaded[0]
    return assembly.loads[0].at if assembly.loads else assembly.sets[0].position


def axial_load(assembly: Assembly) -> float:
    """Sum of the axial loads [N] on shaft and housings."""
    return sum(x.force[2] for x in assembly.loads) + sum(h.force[2] for h in assembly.housings)


def along_axis(assembly: Assembly, result: AxisResult) -> float:
    """Axial displacement [m] of what is asked about."""
    at = asked(assembly)
    if isinstance(at, str):
        return next((float(h.motion[2]) for h in result.housings if h.name == at), 0.0)
    return float(np.interp(at, result.centreline_z, result.centreline[:, 2]))


def loads_of(s: SetResult) -> np.ndarray:
    """Loads [N] of the contacts (N, 4), or of the rollers."""
    return s.balls.load if s.balls is not None else np.zeros(0) if s.rollers is None else s.rollers[:, 1]


def gather(assembly: Assembly, result: AxisResult, member: int = 0) -> AxisAnswers:
    """Answers of a converged result, with the further solution without loads."""
    bare = run_axis(scaled(assembly, 0.0), result.model, member=member)
    sets = tuple(_of_set(s, bare.sets[i] if bare.converged else None) for i, s in enumerate(result.sets))
    moved = along_axis(assembly, result) - along_axis(assembly, bare) if bare.converged else None
    return AxisAnswers(sets, axial_load(assembly), moved)


def _of_set(s: SetResult, bare: SetResult | None) -> SetAnswers | None:
    if s.balls is None or not isinstance(s.of.parts, Scene):
        return None
    found = load_answers(s.of.parts, s.balls.load, s.balls.contact_angle)
    if bare is None or bare.balls is None:
        return SetAnswers(found, None)
    own = bare.balls.load[bare.balls.load > 0.0]
    mean, largest = (mean_load(own), float(own.max())) if own.size else (0.0, 0.0)
    return SetAnswers(found, (mean, largest, int(own.size), float(bare.force[2])))


def curve(assembly: Assembly, factors: Sequence[float], model: str, member: int = 0) -> list[AxisPoint]:
    """The assembly at factors on its loads, those that converge; displacements from the first of them."""
    points: list[AxisPoint] = []
    start: float | None = None
    for factor in factors:
        own = scaled(assembly, factor)
        result = run_axis(own, model, member=member)
        if not result.converged:
            continue
        at = along_axis(own, result)
        start = at if start is None else start
        stiffness = float("nan") if result.stiffness is None else float(result.stiffness[2, 2])
        largest = max((float(loads_of(s).max(initial=0.0)) for s in result.sets), default=0.0)
        points.append(AxisPoint(factor, axial_load(own), at - start, stiffness, largest))
    return points
