"""Keys of a scene that a sweep or a table varies, read from text, and designs of samples.

``KEY=A:B`` is a range, ``KEY=A:B:N`` N equally spaced values of it, ``KEY=v1,v2`` a list, with units as in the scene.
``KEY+KEY=...`` gives several keys the same value. Samples are points of a unit cube (scipy.stats.qmc), with one coordinate
for each varied key.
"""

from __future__ import annotations

import copy
import math
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import numpy as np
from scipy.stats import qmc

from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.fault import value_at_path
from rollbench.meshes.arrays import Array
from rollbench.meshes.units import COMMA, UNDERSCORE, has_comma_in_number, number_advice, split_quantity_text, toml_text

#: Pattern of the path of one key.
_ONE = r"[A-Za-z_]\w*(\[\d+\])*(\.\w+(\[\d+\])*)*"

#: Pattern of the paths of keys that take the same value.
_PATH = re.compile(rf"{_ONE}(\+{_ONE})*")

#: Allowed forms of a text that names a varied key with its values.
_FORM = "KEY=A:B, KEY=A:B:N or KEY=v1,v2, units as in the scene"

#: Groups of keys that state the same quantity, of which a scene has only one; a varied key replaces the others of its
#: group.
_SAME = (
    ("errors.balls.oversize", "preload.oversize", "preload.force"),
    ("preload.lead_offset", "preload.oversize", "preload.force"),
    ("track.pitch_radius", "track.pitch_diameter"),
    ("balls.radius", "balls.diameter"),
    ("balls.count", "balls.filling"),
    ("screw.groove_radius", "screw.conformity"),
    ("nut.groove_radius", "nut.conformity"),
    ("circulation.gap", "circulation.filling"),
    ("time.angle", "time.duration"),
)

#: Largest number of varied keys, and of values of a list.
MOST_KEYS, MOST_VALUES = 20, 1000


#: Short name of the axial component of a scene's only axial load.
LOAD = "load"


@dataclass(frozen=True)
class VariedKey:
    """One varied key of a scene file with its range or list of values, or several keys that take the same value."""

    #: Dotted path of the key with indices from 0, such as ``loads[0].force[2]``; paths of several keys are joined by ``+``.
    key: str
    #: Key with its range or values as the user wrote it, such as "balls.count=20,24".
    stated_text: str
    #: Low end of the key's range, in ``unit``.
    low: float = 0.0
    #: High end of the key's range, in ``unit``.
    high: float = 0.0
    #: Unit of both ends of the range.
    unit: str = ""
    #: Whether the key takes only whole numbers of the range, both ends included.
    whole_numbers_only: bool = False
    #: Values that the key takes, as a scene file writes them; empty: all values of the range.
    listed_values: tuple[Any, ...] = ()
    #: Name that figures show; empty: path of the first key, and number of other keys that take the same value.
    shown_name: str = ""

    def value_at_relative_position(self, relative_position: float) -> Any:
        """Return the value of the key at a relative position (0 to 1) in its range or list, as in a scene file."""
        if self.listed_values:
            return self.listed_values[min(int(relative_position * len(self.listed_values)), len(self.listed_values) - 1)]
        if self.whole_numbers_only:
            return min(int(self.low + relative_position * (self.high - self.low + 1.0)), int(self.high))
        number = float(f"{self.low + relative_position * (self.high - self.low):.12g}")
        return f"{number!r} {self.unit}" if self.unit else number

    def as_number(self, value: Any) -> float:
        """Return a value of the key as a number for plots and means.

        The number is the value in the range's unit or, for a list, the position of the value in the list, from 1.
        """
        if self.listed_values:
            return 1.0 + self.listed_values.index(value)
        return float(value) if isinstance(value, int | float) else float(_split_quantity(value)[0])

    @property
    def trial_values(self) -> tuple[Any, ...]:
        """Values with which the scene is checked before anything is solved: all of a list, or both ends of a range."""
        return self.listed_values or (self.value_at_relative_position(0.0), self.value_at_relative_position(1.0))

    @property
    def axis_label(self) -> str:
        """Key with its unit or list of values, for tables and axes."""
        if self.listed_values:
            shown = [*map(str, self.listed_values[:6]), *(["..."] if len(self.listed_values) > 6 else [])]
            return f"{self.short_name} ({', '.join(shown)})"
        return f"{self.short_name} / {self.unit}" if self.unit else self.short_name

    @property
    def key_paths(self) -> list[str]:
        """Paths of all keys of the scene that take this value."""
        return self.key.split("+")

    @property
    def short_name(self) -> str:
        """Short name: ``shown_name``, else path of the first key, and number of other keys that take the same value."""
        first, *others = self.key_paths
        return self.shown_name or (f"{first} (+{len(others)})" if others else first)


def read_varied_keys_of_table(texts: Sequence[str]) -> tuple[VariedKey, ...]:
    """Read the varied keys of a table from texts, each with all its values.

    ``texts``: a text for each key, such as ``track.contact_angle=40:50:3 deg``. The texts have the form that
    `read_varied_keys` reads, but a range needs a number of values, and the list of texts may be empty. Raises InputError
    for anything else.
    """
    try:
        keys = read_varied_keys(texts) if texts else ()
        for one in keys:
            if not one.listed_values:
                allowed = "a range with the number of its values, KEY=A:B:N, or a list of values, KEY=v1,v2"
                raise _error_for_vary_text(one.stated_text, allowed, f"write for example {one.key}=1:5:9")
    except ArgumentError as error:
        raise ArgumentError("over", *error.args[1:]) if error.key == "vary" else error from None
    return keys


def read_varied_keys(texts: Sequence[str]) -> tuple[VariedKey, ...]:
    """Read the varied keys of a sweep from texts such as "balls.count=20,24", one for each key; a single text is one key.

    Raises InputError for a text of another form, and for a key that is named twice.
    """
    found = tuple(_read_varied_key(text) for text in ((texts,) if isinstance(texts, str) else texts))
    if not 1 <= len(found) <= MOST_KEYS:
        raise ArgumentError("vary", f"{len(found)} keys", f"1 to {MOST_KEYS} keys", f"give {_FORM}")
    paths = [path for one in found for path in one.key_paths]
    for path in paths:
        if paths.count(path) > 1:
            raise ArgumentError("vary", path, "each key once", "put all its values into one text")
    return found


def with_axial_load_key(
    keys: Sequence[VariedKey], raw: dict[str, Any], origin: str, argument: str = "vary"
) -> tuple[VariedKey, ...]:
    """Return varied keys in which the key `LOAD` is that of the scene's axial load, such as ``loads[0].force[2]``.

    ``raw``: TOML tables of the scene; ``origin``: name of its file, and ``argument``: name of the argument with the keys,
    for error messages. Raises ArgumentError if the key is used and the scene has several axial loads or none.
    """
    return tuple(
        replace(x, key="+".join(_axial_load_path(raw, origin, argument) if path == LOAD else path for path in x.key_paths))
        for x in keys
    )


def _axial_load_path(raw: dict[str, Any], origin: str, argument: str) -> str:
    """Return the path of the axial component of a scene's only axial load. Arguments: see `with_axial_load_key`."""
    named = ((f"{table}[{k}]", row) for table in ("loads", "housings") for k, row in enumerate(raw.get(table, ())))
    forces = {f"{name}.force[2]": row["force"] for name, row in named if isinstance(row.get("force"), list)}
    numbers = {key: split_quantity_text(str(force[2])) for key, force in forces.items() if len(force) == 3}
    axial = [key for key, number in numbers.items() if number and float(number[0])] or list(forces)
    if len(axial) != 1:
        advice = 'name the key, such as "loads[0].force[2]"'
        raise ArgumentError(argument, LOAD, f"a scene with one axial load; this scene has {len(axial)}", advice, origin)
    return axial[0]


def _error_for_vary_text(value: str, allowed: str, advice: str = f"give {_FORM}") -> ArgumentError:
    """Return the ArgumentError for a text of the argument ``vary`` that does not name a key with valid values.

    ``value``: text or value that the user gave; ``allowed``: which values are allowed; ``advice``: how to correct the text.
    """
    return ArgumentError("vary", toml_text(value), allowed, advice)


def _read_varied_key(text: str) -> VariedKey:
    """Read one varied key with its list or range of values from a text such as ``balls.count=20,24``."""
    key, sign, values = (piece.strip() for piece in text.partition("="))
    if not sign or not _PATH.fullmatch(key) or not values:
        advice = 'write for example `vary="errors.balls.oversize=0 um:7 um"` or `vary="loads[0].force[2]=1 kN,5 kN"`'
        raise _error_for_vary_text(text, _FORM, advice)
    if any(number_advice(piece, "") == UNDERSCORE for piece in re.split("[:,]", values)):
        raise _error_for_vary_text(text, "numbers with digits, point and exponent only", UNDERSCORE)
    if ":" in values:
        return _read_range(key, text, values)
    parts = [piece.strip() for piece in values.split(",")]
    if not 2 <= len(parts) <= MOST_VALUES or not all(parts):
        raise _error_for_vary_text(text, f"2 to {MOST_VALUES} values with commas between")
    if len(set(parts)) < len(parts):
        raise _error_for_vary_text(text, "a list with each value once", "remove the repeated value")
    return VariedKey(key, text, listed_values=tuple(_toml_value_or_text(piece) for piece in parts))


def _read_range(key: str, text: str, values: str) -> VariedKey:
    """Read a varied key whose values are a range "A:B", or "A:B:N" for N equally spaced values.

    ``key``: path of the key; ``text``: whole text as the user wrote it, for error messages; ``values``: the range in it.
    """
    if any(map(has_comma_in_number, values.split(":"))):
        raise _error_for_vary_text(text, "numbers with a decimal point", COMMA)
    try:
        (first, unit), (second, other), *steps = map(_split_quantity, values.split(":"))
    except ValueError:
        raise _error_for_vary_text(text, "a range A:B of two numbers, with or without unit") from None
    units = list(dict.fromkeys(x for x in (unit, other, *(of for _, of in steps)) if x))
    if len(units) > 1:
        raise _error_for_vary_text(text, "one unit for both ends of the range", f"write both in {units[-1]}")
    low, high, common = float(first), float(second), "".join(units)
    if not low < high:
        raise _error_for_vary_text(text, "a range A:B with A below B", "exchange A and B, or give a list of values")
    if steps:
        values_of = _equally_spaced_values(text, low, high, common, [n for n, _ in steps])
        return VariedKey(key, text, low, high, common, listed_values=values_of)
    whole = not common and all(re.fullmatch(r"[+-]?\d+", end) for end in (first, second))
    return VariedKey(key, text, low, high, common, whole)


def _equally_spaced_values(text: str, low: float, high: float, unit: str, count: Sequence[str]) -> tuple[Any, ...]:
    """Return equally spaced values from ``low`` to ``high``, both included, as a scene file writes them.

    ``text``: whole text as the user wrote it, for error messages; ``unit``: unit of the values; ``count``: number of
    values, as a list with one text.
    """
    if len(count) != 1 or not re.fullmatch(r"\d{1,4}", count[0]) or not 2 <= int(count[0]) <= MOST_VALUES:
        allowed = f"A:B:N with N from 2 to {MOST_VALUES}"
        raise _error_for_vary_text(text, allowed, "write for example nut.position=100:900:9 mm")
    numbers = [float(f"{x:.12g}") for x in np.linspace(low, high, int(count[0]))]
    if unit:
        return tuple(f"{x:.12g} {unit}" for x in numbers)
    return tuple(int(x) if x.is_integer() else x for x in numbers)


def _split_quantity(text: str) -> tuple[str, str]:
    """Return the number, then the unit of a quantity such as "5 um", both as text; raises ValueError for another text."""
    found = split_quantity_text(text)
    if found is None:
        raise ValueError(text)
    return found


def _toml_value_or_text(text: str) -> Any:
    """Return the value that a text such as "24" or "true" has in TOML; the text itself if it is not valid TOML."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def tables_with_varied_keys(raw: dict[str, Any], keys: Sequence[VariedKey], values: Sequence[Any]) -> dict[str, Any]:
    """Return a copy of a scene's TOML tables in which the varied keys have new values.

    Other keys for the same quantities, such as a radius where the diameter varies, are removed. ``raw``: the tables;
    ``keys``: varied keys; ``values``: a value for each key. Raises InputError for the index of a list entry that does not
    exist.
    """
    out = copy.deepcopy(raw)
    for path in (p for vary in keys for p in vary.key_paths):
        for other in _other_keys_for_same_quantity(path):
            _remove_scene_key(out, other)
    for vary, value in zip(keys, values, strict=True):
        for path in vary.key_paths:
            _set_scene_key_value(out, path, value)
    return out


def varied_and_replaced_keys(raw: dict[str, Any], keys: Sequence[VariedKey]) -> list[tuple[str, str]]:
    """Return pairs of keys that state the same quantity: a varied key, and the key of the scene that it replaces.

    An example is ``balls.radius``, which replaces ``balls.diameter``. ``raw``: TOML tables of the scene; ``keys``: varied
    keys.
    """
    pairs = dict.fromkeys(
        (path, other) for vary in keys for path in vary.key_paths for other in _other_keys_for_same_quantity(path)
    )
    return [(path, other) for path, other in pairs if _remove_scene_key(copy.deepcopy(raw), other)]


def _other_keys_for_same_quantity(path: str) -> Iterator[str]:
    """Yield the paths of other scene keys that state the same quantity as ``path``, such as diameter for radius."""
    prefix, key = re.fullmatch(r"(sets\[\d+\]\.)?(.*)", path).groups(default="")  # type: ignore[union-attr]
    for group in _SAME:
        if key in group:
            yield from (prefix + other for other in group if other != key)


def _remove_scene_key(raw: dict[str, Any], key: str) -> bool:
    """Remove a key from a scene's TOML tables, and its table if that gets empty; return whether the key was there."""
    above, _, last = key.rpartition(".")
    node = value_at_path(raw, above)
    if not isinstance(node, dict) or last not in node:
        return False
    del node[last]
    if not node and "." not in above:
        del raw[above]
    return True


def _set_scene_key_value(raw: dict[str, Any], key: str, value: Any) -> None:
    """Set the value of a key in a scene's TOML tables, and create missing tables.

    ``key``: path of the key. Raises InputError for the index of a list entry that does not exist, and for a path through a
    value that is no table.
    """
    *above, last = (int(x) if x.isdigit() else x for x in re.findall(r"[^.\[\]]+", key))
    node: Any = raw
    for step in above:
        _check_path_entry(node, step, key)
        node = node.setdefault(step, {}) if isinstance(node, dict) else node[step]
    _check_path_entry(node, last, key)
    node[last] = value


def _check_path_entry(table_or_list: Any, entry: str | int, key: str) -> None:
    """Raise InputError if a table or list of a scene cannot have the next entry of a key's path.

    ``table_or_list``: the table or list; ``entry``: name or index of the entry; ``key``: whole path, for the error message.
    """
    allowed = "a key of a table, or an entry [0], [1], ... of a list that the scene has"
    if isinstance(table_or_list, dict) and isinstance(entry, str):
        return
    if isinstance(table_or_list, list) and isinstance(entry, int):
        if entry < len(table_or_list):
            return
        allowed = f"entries 0 to {len(table_or_list) - 1}" if table_or_list else "no entry: the scene's list is empty"
    raise _error_for_vary_text(key, allowed, "look up the key in the scene file, or by: rollbench schema")


#: Design of a sweep's samples.
Method = Literal["sobol", "lhs", "grid"]

#: Names of the designs.
METHODS: tuple[Method, ...] = ("sobol", "lhs", "grid")

#: Largest number of samples of a sweep.
MOST = 1_000_000


def base_point_count(sample_count: int, key_count: int) -> int:
    """Return the number n of base points in the Sobol design of a sweep, from which Sobol indices are computed.

    ``sample_count``: requested number of samples; ``key_count``: number of varied keys. n is the power of two, at least 2,
    for which the ratio of the number of samples n (keys + 2) to ``sample_count`` is nearest to 1.
    """
    return max(2, 1 << max(0, round(math.log2(max(sample_count, 1) / (key_count + 2)))))


def sample_coordinates(method: Method, keys: Sequence[VariedKey], samples: int, seed: int) -> Array:
    """Return the m samples of a sweep's design as coordinates in the ranges of d varied keys, (m, d) from 0 to 1.

    Equal arguments give equal samples. The designs are:

    - sobol: n base points A, n base points B, and for each key the points A with the coordinate of that key from B
      (Saltelli et al. 2010), in that order: m = n (d + 2), n by `base_point_count`.
    - lhs: a Latin hypercube.
    - grid: all combinations of the values of lists and of equally spaced values of ranges, ends included, at most
      ``samples``.

    Parameters
    ----------
    method
        Design: ``sobol``, ``lhs`` or ``grid``.
    keys
        Varied keys.
    samples
        Number of samples.
    seed
        Seed of the design.

    Returns
    -------
    Array
        Coordinates of the samples.

    Raises
    ------
    InputError
        For an unknown design or a number of samples out of range.
    """
    if method not in METHODS:
        advice = "choose one of these; only sobol gives sensitivity indices (Sobol indices)"
        raise ArgumentError("method", str(method), ", ".join(METHODS), advice)
    if not 2 <= samples <= MOST:
        raise ArgumentError("samples", str(samples), f"2 to {MOST}", "start with a hundred")
    d = len(keys)
    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(d, rng=np.random.default_rng(seed)).random(samples))
    if method == "grid":
        return _grid_coordinates(keys, samples)
    n = base_point_count(samples, d)
    joined = qmc.Sobol(2 * d, rng=np.random.default_rng(seed)).random(n)
    a, b = joined[:, :d], joined[:, d:]
    mixed = [np.where(np.arange(d) == k, b, a) for k in range(d)]
    return np.concatenate([a, b, *mixed])


def _grid_coordinates(keys: Sequence[VariedKey], largest_count: int) -> Array:
    """Return all m combinations of the values of d varied keys as coordinates in their ranges, (m, d) from 0 to 1.

    ``largest_count``: largest number m of combinations. Raises InputError if it is too small for all values of lists and
    both ends of ranges.
    """
    fixed = math.prod(len(v.listed_values) for v in keys if v.listed_values)
    ranges = sum(not v.listed_values for v in keys)
    steps = int((largest_count / fixed) ** (1.0 / ranges) + 1e-9) if ranges else 1
    if fixed > largest_count or (ranges and steps < 2):
        allowed = f"{fixed * 2**ranges} or more for this grid"
        raise ArgumentError("samples", str(largest_count), allowed, "allow more samples, or take `method=lhs`")
    counts = [len(v.listed_values) for v in keys]
    axes = [(np.arange(n) + 0.5) / n if n else np.linspace(0.0, 1.0, steps) for n in counts]
    return np.array(list(product(*axes)))


def key_values_at_coordinates(keys: Sequence[VariedKey], coordinates: Array) -> list[object]:
    """Return the values of all d varied keys in one sample, as a scene file writes them.

    ``coordinates``: position of the sample in the range of each key, (d,) from 0 to 1.
    """
    return [vary.value_at_relative_position(float(u)) for vary, u in zip(keys, coordinates, strict=True)]
