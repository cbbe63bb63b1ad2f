"""Random extreme scenes solved by a model, each outcome judged: right, refused with proof, or a fault of this project."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

from rollbench.comparison.errors import InputError, SceneError
from rollbench.comparison.models.registry import MODELS, Options, run_model
from rollbench.comparison.scenes import scene_file
from rollbench.comparison.wings.extremes.campaign import check, check_axes
from rollbench.comparison.wings.extremes.campaign.commanded import SAME, Command, misstated
from rollbench.comparison.wings.extremes.campaign.draw import scene_text
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

#: Outcomes, the good ones first.
RIGHT, REFUSED, PROVEN, NOT_UNIQUE = "right", "refused as input", "refused, proven", "refused, contacts not unique"
WRONG, UNPROVEN, SILENT, CRASHED = "wrong", "refused, unproven", "refused without a mechanism", "traceback"
MISSTATED = "misstated by the command line"
GOOD, BAD = (RIGHT, REFUSED, PROVEN, NOT_UNIQUE), (WRONG, UNPROVEN, SILENT, CRASHED, MISSTATED)
#: What draws a scene file from seed and number.
Draw = Callable[[int, int], str]
COMPILED = Options(engine="compiled", discretisation=False)
#: Less energy that plain minimisation may find, over the energy stored in the contacts.
LOWER = 1e-6
#: Every so many scenes small ones are solved by the other engine too, whose loads may differ by ``SAME``.
OTHER_ENGINE, FEW = 10, 40


@dataclass(frozen=True)
class Outcome:
    """One scene: its number, what became of it, in words, the seconds, and whether it was compared by brute force."""

    number: int
    verdict: str
    words: str
    seconds: float
    brute: bool = False


def judge(seed: int, number: int, model: str, command: Command | None = None, draw: Draw = scene_text) -> Outcome:
    """Draw a scene, solve it and judge the outcome, what ``command`` (if given) prints of it too; whatever happens is an
    outcome, never an exception."""
    begin = perf_counter()
    try:
        verdict, words, brute = _judged(draw(seed, number), number, model, command)
    except Exception as error:  # a traceback is what the campaign looks for
        place = traceback.extract_tb(error.__traceback__)[-1]
        verdict, words, brute = CRASHED, f"{type(error).__name__}: {error} ({place.name}, line {place.lineno})", False
    return Outcome(number, verdict, words, perf_counter() - begin, brute)


def _judged(text: str, number: int, model: str, command: Command | None) -> tuple[str, str, bool]:
    found: StaticResult | AxisResult | InputError
    try:
        scene = scene_file.read(text, "campaign.toml")
        if isinstance(scene, Assembly):
            several = found = run_model(scene, model, COMPILED)
            (verdict, words), brute = _of_axis(scene, several, model), False
        else:
            one = scene_file.whole(scene, "campaign.toml")
            alone = found = run_model(one, model, COMPILED)
            verdict, words, brute = _verdict(one, alone, number, model)
    except InputError as error:
        named = isinstance(error, SceneError) or bool(error.key and error.value)
        found, verdict, words, brute = error, REFUSED if named else SILENT, str(error), False
    if command is not None and verdict in GOOD:
        fault = misstated(text, model, found, command)
        return (MISSTATED, fault, brute) if fault else (verdict, words, brute)
    return verdict, words, brute


def _of_axis(assembly: Assembly, result: AxisResult, model: str) -> tuple[str, str]:
    """Verdict on several sets on one shaft."""
    if result.converged:
        fault = check_axes.faults(assembly, result) if model == "lin" else ""
        return (WRONG, fault) if fault else (RIGHT, "")
    if result.status.kind != "not held":
        return SILENT, result.status
    runner = MODELS[model].assembly
    if result.status.cause == "crossed row" and callable(runner):  # the state with arcs that go on across the bottom
        state = runner(assembly, COMPILED)
        return (UNPROVEN if check_axes.faults(assembly, state) or not check_axes.crossed(state) else PROVEN), result.status
    mounting = result.status.cause == "mounting"
    return (PROVEN if check_axes.proven(assembly, mounting) else UNPROVEN), result.status


def _verdict(scene: Scene, result: StaticResult, number: int, model: str) -> tuple[str, str, bool]:
    if not result.converged:
        return (*_refusal(scene, result), False)
    fault = check.unbalanced(scene, result) or (check.off_the_law(scene, result) if model == "lin" else "")
    if fault:
        return WRONG, fault, False
    if number % OTHER_ENGINE == 0 and scene.ball_count <= FEW:
        other = run_model(scene, model, Options(engine="interpreted", discretisation=False))
        if other.status != result.status:
            return WRONG, f"the other engine says: {other.status}", False
        apart = float(abs(other.load - result.load).max())
        if apart > max(SAME * float(result.load.max()), check.nothing(result)):
            return WRONG, f"loads of the two engines differ by {apart:.3g} N", False
    lower = check.brute_force(scene, result) if model == "lin" else None
    if lower is not None and lower > LOWER:
        return WRONG, f"plain minimisation finds {lower:.2g} of the stored energy less", True
    return RIGHT, "", lower is not None


def _refusal(scene: Scene, result: StaticResult) -> tuple[str, str]:
    """Verdict on a result without loads."""
    if result.status.kind == "not held":
        return (PROVEN if check.proven(scene) else UNPROVEN), result.status
    if result.status.cause == "not unique":
        return NOT_UNIQUE, result.status
    return SILENT, result.status


def judge_scenes(
    seed: int,
    count: int,
    model: str,
    progress: Callable[[int, int, str], None] | None = None,
    known: Mapping[int, Outcome] | None = None,
    keep: Callable[[Outcome], None] | None = None,
    command: Command | None = None,
    draw: Draw = scene_text,
) -> list[Outcome]:
    """``count`` scenes one after another; progress: as for ``compare.wings.extremes.static.table``; known: outcomes by
    number that are taken as they are; keep: called with every new one; command: the command line, which must say the same;
    draw: what gives a scene's text."""
    found = []
    for number in range(count):
        outcome = None if known is None else known.get(number)
        if outcome is None:
            outcome = judge(seed, number, model, command, draw)
            if keep is not None:
                keep(outcome)
        found.append(outcome)
        if progress is not None:
            progress(number + 1, count, f"scene {number}: {outcome.verdict}")
    return found


def tally(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many outcomes of each kind, and how many were compared by brute force."""
    counts = {verdict: sum(o.verdict == verdict for o in outcomes) for verdict in (*GOOD, *BAD)}
    return counts | {"compared with plain minimisation": sum(o.brute for o in outcomes)}
