"""Faults of a scene file, and one SceneError of all of them: which key is named, what is allowed there, what to do."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rollbench.compare.errors import SceneError
from rollbench.meshes.units import show

#: Lengths that differ by less than this [m] count as equal.
TOLERANCE = 1e-9
#: Keys that a file may have in place of another one.
ALIASES = {
    "track.pitch_radius": ("track.pitch_diameter",),
    "balls.radius": ("balls.diameter",),
    "balls.count": ("balls.filling",),
    "errors.balls.oversize": ("preload.oversize", "preload.force"),
}


@dataclass(frozen=True)
class Fault:
    """One fault: the keys it may be blamed on (the first one that the file has is named), and what to say.

    ``value`` is left empty where the text found in the file says it best.
    """

    keys: tuple[str, ...]
    allowed: str
    advice: str
    value: str = ""


def mm(length: float) -> str:
    """A length [m] for a message: in mm, or in um below 0.1 mm."""
    return f"{length * 1e6:.6g} um" if 0.0 < abs(length) < 1e-4 else f"{length * 1e3:.7g} mm"


class Said(NamedTuple):
    """One fault in words: key, value found, what is allowed, what to do."""

    key: str
    value: str
    allowed: str
    advice: str


def refusal(origin: str, said: Sequence[Said]) -> SceneError:
    """All faults of a file as one error: the first, with the others."""
    errors = [SceneError(origin, *one) for one in said]
    return SceneError(origin, *said[0], len(said) - 1, tuple(errors[1:]))


def refuse(origin: str, raw: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Raise all faults, if any."""
    if faults:
        raise refusal(origin, spoken(raw, faults))


def spoken(raw: Mapping[str, Any], faults: Sequence[Fault]) -> list[Said]:
    """Faults in words, each blaming the first of its keys that the file has, under the name that it has there."""
    out = []
    for fault in faults:
        names = [name for key in fault.keys for name in (key, *_aliases(key))]
        present = ((name, value) for name in names if (value := _find(raw, name)) is not None)
        key, given = next(present, (fault.keys[-1], None))
        value = fault.value or ("nothing" if given is None else show(given))
        half = key not in fault.keys and key.endswith("diameter")
        out.append(Said(key, value, fault.allowed, f"as a radius; {fault.advice}" if half else fault.advice))
    return out


def _aliases(key: str) -> Iterator[str]:
    """Keys that a file may have in place of a key."""
    for suffix, others in ALIASES.items():
        if key.endswith(suffix):
            yield from (key.removesuffix(suffix) + other for other in others)


def _find(raw: Any, path: str) -> Any:
    for key in re.findall(r"[^.\[\]]+", path):
        if isinstance(raw, list):
            raw = raw[int(key)] if int(key) < len(raw) else None
        elif isinstance(raw, dict):
            raw = raw.get(key)
        else:
            return None
    return raw
