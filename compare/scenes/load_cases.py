"""From ``[[cases]]`` of a scene file to a duty cycle, and what is wrong with them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from rollbench.compare.scenes.duty_cycle import DutyCycle, LoadCase
from rollbench.compare.scenes.fault import Fault, mm, refuse
from rollbench.compare.scenes.schema import CaseKeys, SceneKeys
from rollbench.meshes.axis import Assembly
from rollbench.meshes.partition import MERGE
from rollbench.meshes.parts import Errors, Motion, Scene, Support

if TYPE_CHECKING:
    from rollbench.compare.scenes.axis_schema import AxisKeys

Parts = TypeVar("Parts", bound="Scene | Assembly")
#: Largest distance of the sum of shares from 1: shares are written with a few digits.
ROUNDED = 1e-6


def in_cases(
    parts: Parts, keys: Sequence[CaseKeys], raw: Mapping[str, Any], origin: str, faults: Callable[[Any], Iterable[Fault]]
) -> Parts | DutyCycle:
    """The parts, or the duty cycle of their cases; faults: of the parts in one case. Raises SceneError."""
    if not keys:
        return parts
    cycle = duty_cycle(parts, keys)
    refuse(origin, raw, [of_case(fault, k) for k, case in enumerate(cycle.cases) for fault in faults(case.scene)])
    return cycle


def duty_cycle(scene: Scene | Assembly, keys: Sequence[CaseKeys]) -> DutyCycle:
    """The record of faultless cases of a scene.

    Shares follow from times and speeds: revolutions of a case over those of the cycle, whichever way it turns.
    """
    turned = [0.0 if k.time is None else k.time * abs(k.speed or 0.0) for k in keys]
    whole, time = sum(turned), sum(k.time or 0.0 for k in keys)
    shares = [k.share or 0.0 for k in keys] if whole == 0.0 else [x / whole for x in turned]
    speed = whole / time if whole else None if scene.motion is None else abs(scene.motion.speed)
    cases = (LoadCase(k.name, share, k.speed, _scene(scene, k), k.time) for k, share in zip(keys, shares, strict=True))
    return DutyCycle(scene, tuple(cases), speed)


def _scene(scene: Scene | Assembly, keys: CaseKeys) -> Scene | Assembly:
    """The scene in one case, under a name of its own: stored runs and files are told apart by it."""
    motion = scene.motion
    if keys.speed is not None:
        motion = Motion(keys.speed) if motion is None else replace(motion, speed=keys.speed)
    case = replace(
        scene,
        name=f"{scene.name}-{keys.name}",
        loads=scene.loads if keys.loads is None else tuple(keys.loads),
        supports=tuple(_displaced(s, keys) for s in scene.supports),
        motion=motion,
    )
    if isinstance(case, Scene):
        return replace(case, errors=_errors(case, keys))
    each = ((s, s.parts) for s in case.sets)
    sets = (replace(s, parts=replace(p, errors=_errors(p, keys))) if isinstance(p, Scene) else s for s, p in each)
    loaded: dict[str, dict[str, Any]] = {
        h.name: {"force": h.force, "moment": h.moment} for h in getattr(keys, "housings", ())
    }
    housings = (replace(h, **loaded.get(h.name, {})) for h in case.housings)
    return replace(case, sets=tuple(sets), housings=tuple(housings))


def _errors(scene: Scene, keys: CaseKeys) -> Errors:
    oversize = scene.errors.balls.oversize if keys.oversize is None else keys.oversize
    return replace(scene.errors, balls=replace(scene.errors.balls, oversize=oversize))


def _displaced(support: Support, keys: CaseKeys) -> Support:
    moved: dict[str, float] = {}
    for other in keys.supports:
        if abs(other.at - support.at) <= MERGE:
            moved |= other.displace.given
    return replace(support, fixed=tuple((name, moved.get(name, value)) for name, value in support.fixed))


def case_faults(keys: SceneKeys | AxisKeys) -> Iterator[Fault]:
    """Names, shares and supports of the cases that do not fit together."""
    names = [case.name for case in keys.cases]
    for k, case in enumerate(keys.cases):
        where = f"cases[{k}]"
        if not re.fullmatch(r"[\w.-]{1,60}", case.name):
            advice = 'it becomes a part of file names: write e.g. name = "rapid-travel"'
            yield Fault((f"{where}.name",), "up to 60 letters, digits, . _ and -", advice)
        if case.name in names[:k]:
            yield Fault((f"{where}.name",), "a name of its own", "results are told apart by it: change one")
        yield from _share_faults(case, where)
        yield from _support_faults(keys, case, where)
    if not keys.cases or any((case.share is None) == (case.time is None) for case in keys.cases):
        return
    timed = [k for k, case in enumerate(keys.cases) if case.time is not None]
    shared = [k for k, case in enumerate(keys.cases) if case.share]
    if timed and shared:
        advice = "give all cases a share, or all time and speed; share = 0 may stand with times"
        yield Fault((f"cases[{shared[0]}].share",), "0 with cases that have a time", advice)
    elif timed and not any(keys.cases[k].time for k in timed):
        yield Fault((f"cases[{timed[0]}].time",), "above 0 s in one of the cases", "shares follow from times: mend one")
    elif not timed and abs(sum(case.share or 0.0 for case in keys.cases) - 1.0) > ROUNDED:
        total = sum(case.share or 0.0 for case in keys.cases)
        advice = "shares are parts of all revolutions: write fractions that sum to 1; 0 is a static check only"
        yield Fault((f"cases[{(shared or [0])[-1]}].share",), "shares that sum to 1", advice, f"a sum of {total:.7g}")


def _share_faults(case: CaseKeys, where: str) -> Iterator[Fault]:
    """A case has a share, or time and speed."""
    if (case.share is None) == (case.time is None):
        given = "neither" if case.share is None else "both"
        advice = 'write share = 0.5, or time = "20 s" with speed = "200 rpm"'
        yield Fault((f"{where}.share",), "either share or time", advice, given)
    elif case.time is not None and case.speed is None:
        advice = 'the share of the revolutions follows from both: write e.g. speed = "200 rpm"'
        yield Fault((f"{where}.speed",), "a speed with a time", advice, "nothing")
    if case.speed == 0.0:
        advice = "write share = 0 for a case at rest: it is checked statically only"
        yield Fault((f"{where}.speed",), "any angular speed but zero", advice)


def _support_faults(keys: SceneKeys | AxisKeys, case: CaseKeys, where: str) -> Iterator[Fault]:
    """A case displaces freedoms that the scene's supports hold, each once."""
    seen: set[tuple[int, str]] = set()
    for j, other in enumerate(case.supports):
        supports = [(i, s) for i, s in enumerate(keys.supports) if abs(s.at - other.at) <= MERGE]
        if not supports:
            places = ", ".join(mm(s.at) for s in keys.supports) or "none: the scene has no supports"
            advice = "a case displaces supports that the scene has: mend the station, or add the support to the scene"
            yield Fault((f"{where}.supports[{j}].at",), places, advice)
            continue
        held = {name: i for i, s in supports for name in s.held}
        for name in other.displace.given:
            key = f"{where}.supports[{j}].displace.{name}"
            if name not in held:
                advice = "a case does not hold other freedoms than the scene: add it to fix of the scene's support"
                yield Fault((key,), ", ".join(held), advice, name)
            elif (held[name], name) in seen:
                yield Fault((key,), "each freedom once in a case", "keep one of the two", f"{name} twice")
            else:
                seen.add((held[name], name))


def of_case(fault: Fault, k: int) -> Fault:
    """A fault of the scene of case number ``k``, blamed on the keys of the case where it has them."""
    blamed = tuple(f"cases[{k}].{key}" for key in fault.keys if key.startswith(("loads", "supports")))
    oversize = () if blamed else (f"cases[{k}].oversize",)
    return replace(fault, keys=(*blamed, *oversize, *fault.keys))
