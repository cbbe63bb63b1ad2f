"""The rest of a scene whose keys are faulty: read on with what is sound, so that all its faults are told at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from rollbench.comparison.scenes.keys import tidy_schema
from rollbench.comparison.scenes.refusal import Said, refusal

Keys = TypeVar("Keys", bound=BaseModel)

#: Tables and keys on which no body, support or load depends.
APART = {"title", "source", "assumed", "role", "members", "kind", "friction", "motion", "gate"}


@dataclass(frozen=True)
class Broken:
    """What is wrong with the keys of a file, and the tables (or keys outside tables) that were mended to read on."""

    said: tuple[Said, ...] = ()
    mended: frozenset[str] = frozenset()

    @property
    def bodies(self) -> bool:
        """Whether bodies, supports and loads are as the file says."""
        return self.mended <= APART

    def leaves(self, keys: Sequence[str]) -> bool:
        """Whether a fault of these keys is the file's own: no table that was mended has a part in it."""
        return not any(key.split(".")[0].split("[")[0] in self.mended for key in keys)


def sound(raw: Mapping[str, Any], keys: type[Keys], origin: str) -> Keys:
    """Keys of a file, each by itself in range. Raises SceneError with all faults."""
    try:
        return keys.model_validate(raw)
    except ValidationError as error:
        from rollbench.comparison.scenes.key_faults import key_faults

        raise refusal(origin, key_faults(keys, error)) from None


def validated(raw: Mapping[str, Any], keys: type[Keys]) -> tuple[Keys | None, Broken]:
    """Keys of a file and what is wrong with them; faulty values are replaced by examples, unknown keys left out.

    None where that does not make the file readable, as where a whole table is missing.
    """
    try:
        return keys.model_validate(raw), Broken()
    except ValidationError as error:
        from rollbench.comparison.scenes.key_faults import key_faults, node_at, unknown

        faults = error.errors(include_url=False)
        said = tuple(key_faults(keys, error))
    schema, rest, names = tidy_schema(keys), deepcopy(dict(raw)), set()
    for fault in faults:
        where = fault["loc"]
        whole = len(where) == 1 and fault["type"] == "extra_forbidden"  # what it stands for is missing, if anything
        names |= {unknown(schema, fault)[1]} - {""} if whole else {str(key) for key in where[:1]}
        if not where or not _mend(rest, where, fault["type"], node_at(schema, where)):
            return None, Broken(said, frozenset(names))
    try:
        return keys.model_validate(rest), Broken(said, frozenset(names))
    except ValidationError:
        return None, Broken(said, frozenset(names))


def _mend(raw: Any, where: Sequence[int | str], kind: str, node: Mapping[str, Any]) -> bool:
    """Replace or leave out one value in place; whether that could be done."""
    for key in where[:-1]:
        known = isinstance(raw, list) if isinstance(key, int) else isinstance(raw, dict) and key in raw
        if not known:
            return False
        raw = raw[key]
    last: Any = where[-1]
    examples = node.get("examples", [])
    if kind != "extra_forbidden" and examples and "properties" not in node and isinstance(raw, list | dict):
        raw[last] = deepcopy(examples[0])
        return True
    if isinstance(raw, dict):
        raw.pop(last, None)
        return kind != "missing"
    return False
