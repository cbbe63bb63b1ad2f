"""Scene files: one TOML file is one load case, or several of the same parts; what cannot be read or built is refused in one
line."""

from __future__ import annotations

import difflib
import hashlib
import re
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from rollbench.comparison.errors import SceneError, escaped
from rollbench.comparison.registration import kinds
from rollbench.comparison.scenes.body_checks import contact_faults, geometry_faults
from rollbench.comparison.scenes.fault import Fault
from rollbench.comparison.scenes.key_checks import choice_faults
from rollbench.comparison.scenes.load_cases import DutyCycle, case_faults, duty_cycle, of_case
from rollbench.comparison.scenes.mending import sound, validated
from rollbench.comparison.scenes.names import AXIS, WHOLE
from rollbench.comparison.scenes.records import scene_of
from rollbench.comparison.scenes.refusal import refusal, refuse, spoken
from rollbench.comparison.scenes.schema import SceneKeys
from rollbench.comparison.scenes.units import show
from rollbench.meshes.axis import Assembly
from rollbench.meshes.one_arc import as_one_arc
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.comparison.scenes.axis_schema import AxisKeys
    from rollbench.comparison.scenes.kinds import KindScene

#: What a scene file describes.
Described: TypeAlias = "Scene | KindScene | Assembly | DutyCycle"
#: Most parts of a dotted key: the reader's time and memory grow with their square.
MAX_PARTS = 32
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DOTTED = re.compile(rf"""(?<![\w\-."'])(?:{_PART}[ \t]*+\.[ \t]*+){{{MAX_PARTS}}}""")
#: Largest scene file [bytes] and longest line [characters]: 100 000 listed azimuths on one line have 2 MB.
MAX_BYTES, MAX_LINE = 4_000_000, 2_500_000
#: Tables that no whole screw or bearing has; without a kind they tell that one is missing.
FOREIGN = {"load", "angles", "grooves", "chain", "four_point", "double_row"}


def load(path: str | Path) -> Scene:
    """The whole screw or bearing in the file ``path``; its name is the file's stem. Raises SceneError."""
    return loads(read_text(path), str(path))


def loads(text: str, origin: str) -> Scene:
    """The whole screw or bearing in ``text``; ``origin`` is the file named in errors.

    Raises SceneError, also for a scene of a kind that only friction solves, and nothing else.
    """
    return whole(read(text, origin), origin)


def solvable(scene: Described, origin: str) -> Scene | Assembly:
    """The scene, if it is a whole one of one set, or several sets on one shaft. Raises SceneError as `whole`."""
    return scene if isinstance(scene, Assembly) else whole(scene, origin)


def each_case(scene: Described, origin: str) -> list[Scene] | list[Assembly]:
    """The scenes to be solved for one that is described: one, or that of every load case in order. Raises SceneError as
    `whole`."""
    if isinstance(scene, DutyCycle):
        return [case.scene for case in scene.cases]  # type: ignore[return-value]
    found = solvable(scene, origin)
    return [found]  # type: ignore[return-value]


def whole(scene: Described, origin: str) -> Scene:
    """The scene, if it is one whole screw or bearing. Raises SceneError naming its kind where it is another."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, DutyCycle):
        advice = "leave the cases out here; solve, compare, check, friction, sweep and report take them"
        raise SceneError(origin, "cases", f"{len(scene.cases)} cases", "a scene without [[cases]]", advice)
    if isinstance(scene, Assembly):
        advice = "this command takes one nut or ring with its balls: take solve, compare, check, friction or sweep"
        raise SceneError(origin, "sets", f"{len(scene.sets)} sets", "one set that stands", advice)
    advice = f"only friction solves this kind: rollbench friction {origin.removesuffix('.toml')}"
    raise SceneError(origin, "kind", show(scene.kind), ", ".join(map(show, WHOLE)), advice)


def read(text: str, origin: str) -> Described:
    """The scene of any kind in ``text``; ``origin`` is the file named in errors. Raises SceneError, and nothing else."""
    return read_tables(read_toml(text, origin), origin)


def read_tables(raw: dict[str, Any], origin: str) -> Described:
    """The scene of any kind of the tables ``raw``. Raises SceneError, and nothing else."""
    kind = raw.get("kind")
    if "sets" in raw or kind == AXIS:
        return _read_axis(raw, origin)
    nut = raw.get("nut")
    bodies = isinstance(nut, dict) and "length" in nut  # a whole scene with a key misspelt
    if kind is None and FOREIGN & raw.keys() and not bodies:
        name = sorted(FOREIGN & raw.keys())[0]
        advice = f"[{name}] belongs to a kind that only friction solves: name it, as rollbench new FILE --kind KIND does"
        raise SceneError(origin, "kind", "nothing", ", ".join(map(show, kinds())), advice)
    if kind is None or kind in WHOLE:
        return of_tables(raw, origin)
    if kind not in kinds():
        near = difflib.get_close_matches(str(kind), (*WHOLE, *kinds()), n=1, cutoff=0.5)
        advice = f"did you mean {show(near[0])}?" if near else "leave it out for a whole screw or bearing"
        raise SceneError(origin, "kind", show(kind), ", ".join(map(show, (*WHOLE, *kinds()))), advice)
    from rollbench.comparison.scenes.kinds import kind_named

    of = kind_named(kind)
    keys = sound(raw, of.keys, origin)
    refuse(origin, raw, list(of.faults(keys)))
    return of.record(keys, escaped(Path(origin).stem))


def _read_axis(raw: dict[str, Any], origin: str) -> Scene | Assembly | DutyCycle:
    from rollbench.comparison.scenes.axis_file import read_axis

    return read_axis(_axis_keys(raw, origin), raw, origin, Path(origin).stem)


def _axis_keys(raw: dict[str, Any], origin: str) -> AxisKeys:
    from rollbench.comparison.scenes.axis_schema import AxisKeys

    return sound(raw, AxisKeys, origin)


def kind_of(scene: Described) -> str:
    """The kind of a scene, as its file may name it."""
    scene = scene.parts if isinstance(scene, DutyCycle) else scene
    if not isinstance(scene, Scene):
        return scene.kind
    return "bearing" if scene.track.lead == 0.0 else "ball screw"


def keys_of(raw: dict[str, Any], origin: str) -> SceneKeys | AxisKeys:
    """The keys of the tables ``raw`` of a whole screw or bearing, or of several sets on one shaft, each by itself in range.

    Raises SceneError.
    """
    if "sets" in raw or raw.get("kind") == AXIS:
        return _axis_keys(raw, origin)
    return sound(raw, SceneKeys, origin)


def of_tables(raw: dict[str, Any], origin: str) -> Scene | DutyCycle:
    """The whole screw or bearing of the tables ``raw``, in one load case or several; ``origin``: the file named in errors.

    Raises SceneError with all that is wrong, as far as it can be told before the first faults are mended.
    """
    keys, broken = validated(raw, SceneKeys)
    said = list(broken.said)
    if keys is not None:
        faults = (*choice_faults(keys), *case_faults(keys))
        said += spoken(raw, [fault for fault in faults if broken.leaves(fault.keys)])
    if keys is None or not broken.bodies or len(said) > len(broken.said):
        raise refusal(origin, said)
    scene = scene_of(keys, escaped(Path(origin).stem))
    said += spoken(raw, _body_faults(scene))
    if said:
        raise refusal(origin, said)
    if keys.preload is not None:
        from rollbench.comparison.scenes.preload import preloaded

        scene = preloaded(scene, keys.preload)
        refuse(origin, raw, _body_faults(scene))
    scene = as_one_arc(scene)
    if not keys.cases:
        return scene
    cycle = duty_cycle(scene, keys.cases)
    refuse(
        origin, raw, [of_case(f, k) for k, case in enumerate(cycle.cases) for f in _body_faults(whole(case.scene, origin))]
    )
    return cycle


def _body_faults(scene: Scene) -> list[Fault]:
    """Bodies that cannot be built; where all can, contacts that cannot be solved."""
    return list(geometry_faults(scene)) or list(contact_faults(scene))


def read_text(path: str | Path) -> str:
    """Text of a file, as UTF-8. Raises SceneError if it cannot be read or is not text."""
    allowed = "a readable TOML file"
    try:
        if Path(path).is_dir():
            raise SceneError(str(path), "file", "a directory", allowed, "name a file inside it")
        if Path(path).exists() and not Path(path).is_file():
            raise SceneError(str(path), "file", "a pipe or device", allowed, "name a regular file")
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        advice = "check the path, or see the shipped scenes with: rollbench list"
        raise SceneError(str(path), "file", reason.lower(), allowed, advice) from None
    if len(data) > MAX_BYTES:
        value = f"more than {MAX_BYTES // 1_000_000} MB"
        allowed = f"up to {MAX_BYTES // 1_000_000} MB"
        raise SceneError(str(path), "file", value, allowed, "is this a scene file?")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text, place = "\0", f"byte {error.start} is not UTF-8"
    else:
        place = "it contains NUL bytes"
    if "\0" in text:
        advice = f"{place}: save the scene as plain UTF-8 text"
        raise SceneError(str(path), "file", "a binary file", "UTF-8 text", advice)
    longest = max(map(len, text.splitlines()), default=0)
    if longest > MAX_LINE:
        raise SceneError(str(path), "file", f"a line of {longest} characters", f"up to {MAX_LINE}", "is this a scene file?")
    return text


def scene_hash(text: str) -> str:
    """First 16 hexadecimal digits of the SHA-256 of a scene's text, without its role: that says nothing of the scene."""
    described = re.sub(r"(?m)^role = .*\n", "", text)
    return hashlib.sha256(described.encode("utf-8", "surrogatepass")).hexdigest()[:16]


def read_toml(text: str, origin: str) -> dict[str, Any]:
    """Tables and keys of a TOML text; ``origin`` is the file named in errors. Raises SceneError."""
    if long := _DOTTED.search(text):
        row = text.count("\n", 0, long.start()) + 1
        advice = "keys of scenes have up to four: rollbench schema lists them"
        raise SceneError(origin, f"line {row}", f"{long[0][:40]}...", f"a key of up to {MAX_PARTS} parts", advice)
    try:
        return tomllib.loads(text)
    except RecursionError:
        place, reason = "file", "brackets are nested too deeply"
    except ValueError as error:  # TOMLDecodeError, and integers of thousands of digits
        match = re.search(r"\s*\(at (.*)\)$", str(error))
        place = match[1] if match else "file"
        reason = str(error)[: match.start()] if match else str(error)
    found = re.match(r"line (\d+)", place)
    line = text.splitlines()[int(found[1]) - 1].strip() if found else "text that is not TOML"
    advice = f'{reason[:1].lower()}{reason[1:]}; texts need double quotes, e.g. length = "800 mm"'
    raise SceneError(origin, place, line or "an empty line", "TOML: [table] and key = value lines", advice)
