"""Random extreme scenes solved by a model, each outcome judged: right, refused with proof, or a fault of this project."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

from compare.errors import InputError, SceneError
from compare.extremes.campaign import check
from compare.extremes.campaign.draw import scene_text
from compare.models.registry import Options, run_model
from compare.scenes import scene_file
from lowfi.statics.result import StaticResult
from meshes.parts import Scene

#: Outcomes, the good ones first.
RIGHT, REFUSED, PROVEN, NOT_UNIQUE = "right", "refused as input", "refused, proven", "refused, contacts not unique"
WRONG, UNPROVEN, SILENT, CRASHED = "wrong", "refused, unproven", "refused without a mechanism", "traceback"
GOOD, BAD = (RIGHT, REFUSED, PROVEN, NOT_UNIQUE), (WRONG, UNPROVEN, SILENT, CRASHED)
#: Less energy that plain minimisation may find, over the energy stored in the contacts.
LOWER = 1e-6
#: Every so many scenes small ones are solved by the other engine too, whose loads may differ by this share of the largest.
OTHER_ENGINE, FEW, SAME = 10, 40, 1e-5


@dataclass(frozen=True)
class Outcome:
    """One scene: its number, what became of it, in words, the seconds, and whether it was compared by brute force."""

    number: int
    verdict: str
    words: str
    seconds: float
    brute: bool = False


def judge(seed: int, number: int, model: str) -> Outcome:
    """Draw a scene, solve it and judge the outcome; whatever happens is an outcome, never an exception."""
    begin = perf_counter()
    try:
        verdict, words, brute = _judged(scene_text(seed, number), number, model)
    except Exception as error:  # a traceback is what the campaign looks for
        place = traceback.extract_tb(error.__traceback__)[-1]
        verdict, words, brute = CRASHED, f"{type(error).__name__}: {error} ({place.name}, line {place.lineno})", False
    return Outcome(number, verdict, words, perf_counter() - begin, brute)


def _judged(text: str, number: int, model: str) -> tuple[str, str, bool]:
    try:
        scene = scene_file.loads(text, "campaign.toml")
        result = run_model(scene, model, Options(engine="compiled", discretisation=False))
    except SceneError as error:
        return REFUSED, str(error), False
    except InputError as error:
        named = bool(error.key and error.value)
        return (REFUSED if named else SILENT), str(error), False
    if not result.converged:
        return (*_refusal(scene, result), False)
    fault = check.unbalanced(scene, result)
    if fault:
        return WRONG, fault, False
    if number % OTHER_ENGINE == 0 and scene.ball_count <= FEW:
        other = run_model(scene, model, Options(engine="interpreted", discretisation=False))
        if other.status != result.status:
            return WRONG, f"the other engine says: {other.status}", False
        apart = float(abs(other.load - result.load).max())
        if apart > max(SAME * float(result.load.max()), check.nothing(scene, result)):
            return WRONG, f"loads of the two engines differ by {apart:.3g} N", False
    lower = check.brute_force(scene, result) if model == "lin" else None
    if lower is not None and lower > LOWER:
        return WRONG, f"plain minimisation finds {lower:.2g} of the stored energy less", True
    return RIGHT, "", lower is not None


def _refusal(scene: Scene, result: StaticResult) -> tuple[str, str]:
    """Verdict on a result without loads."""
    if result.status.startswith("not held"):
        return (PROVEN if check.proven(scene) else UNPROVEN), result.status
    if "not unique" in result.status:
        return NOT_UNIQUE, result.status
    return SILENT, result.status


def judge_scenes(
    seed: int,
    count: int,
    model: str,
    progress: Callable[[int, int, str], None] | None = None,
    known: Mapping[int, Outcome] | None = None,
    keep: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """``count`` scenes one after another; progress: as for ``compare.extremes.static.table``; known: outcomes by number
    that are taken as they are; keep: called with every new one."""
    found = []
    for number in range(count):
        outcome = None if known is None else known.get(number)
        if outcome is None:
            outcome = judge(seed, number, model)
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
