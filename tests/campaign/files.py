"""Mutated scene files and stored files, and kills while a file is written: refused in words, never half-written."""

import os
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import sleep

import numpy as np
from tests.campaign.draw import scene_text
from tests.campaign.scenes import placed

from rollbench.compare.errors import SceneError
from rollbench.compare.files import replace_file
from rollbench.compare.reference.store import read_checked_data, run_text_with_checksum
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.meshes.condensed import CondensedBodies, read_condensed_bodies

#: What a mutated file may become.
READ, REFUSED, CRASHED, CHANGED = "read as before", "refused", "traceback", "other numbers read"
#: Texts that are put in the place of a value.
VALUES = ('"1e308 mm"', '"-1 mm"', "nan", "-inf", "[]", '""', "true", "1e400", '"9 GPa"', "{}", '"\\u0000"')
VALUES += ("10**9", '"0 mm"')
#: A process that writes one file after another until it is killed.
WRITER = """
import sys
from pathlib import Path
from rollbench.compare.files import replace_file
k = 0
print("ready", flush=True)
while True:
    replace_file(Path(sys.argv[1]), str(k % 10) * 400_000)
    k += 1
"""


@dataclass(frozen=True)
class FileOutcome:
    """Outcome of one mutated file or kill: its kind, the verdict, whether that is good, message."""

    kind: str
    verdict: str
    good: bool
    words: str = ""


def mutated(text: bytes, rng: np.random.Generator) -> bytes:
    """A text with one to three faults: bytes flipped, cut or doubled, lines dropped or swapped, other values."""
    for _ in range(int(rng.integers(1, 4))):
        lines = text.split(b"\n")
        k, place = int(rng.integers(len(lines))), int(rng.integers(max(len(text), 1)))
        way = int(rng.integers(7))
        if way == 0:
            text = text[:place] + bytes([int(rng.integers(256))]) + text[place + 1 :]
        elif way == 1:
            text = text[:place]
        elif way == 2:
            text = text[:place] + text[place : place + 50] * int(rng.integers(2, 6)) + text[place:]
        elif way == 3:
            text = b"\n".join(lines[:k] + lines[k + 1 :])
        elif way == 4:
            other = int(rng.integers(len(lines)))
            lines[k], lines[other] = lines[other], lines[k]
            text = b"\n".join(lines)
        elif b"=" in lines[k]:
            lines[k] = lines[k].split(b"=")[0] + b"= " + str(rng.choice(VALUES)).encode()
            text = b"\n".join(lines)
    return text


def _outcome(
    kind: str, read: Callable[[], bool], refusal: type[Exception], told: Callable[[Exception], bool] = lambda _: True
) -> FileOutcome:
    """What becomes of a file. read: reads it, and says whether what it holds is right; refusal: what it may raise; told:
    whether such a message says enough."""
    try:
        same = read()
    except refusal as error:
        return FileOutcome(kind, REFUSED, told(error), str(error))
    except Exception as error:  # what the campaign looks for
        return FileOutcome(kind, CRASHED, False, placed(error))
    return FileOutcome(kind, READ if same else CHANGED, same)


def scenes(seed: int, count: int) -> Iterator[FileOutcome]:
    """Mutated scene files: shipped ones of every kind, and drawn ones."""
    names = catalogue.scene_names()

    def told(error: Exception) -> bool:
        named = isinstance(error, SceneError) and error.key != "" and error.value != ""
        return named and "\n" not in str(error) and "mutated.toml" in str(error)

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mutated.toml"
        for number in range(count):
            rng = np.random.default_rng([seed, 1, number])
            drawn = scene_text(seed, number) if number % 2 else catalogue.shipped_scene_text(str(rng.choice(names)))
            path.write_bytes(mutated(drawn.encode(), rng))
            yield _outcome(
                "scene", lambda: bool(scene_file.parse_scene(scene_file.read_scene_text(path), str(path))), SceneError, told
            )


def stored(seed: int, count: int) -> Iterator[FileOutcome]:
    """Mutated runs and condensed bodies: only what was written may be read."""
    run = {"load": np.arange(24.0).reshape(6, 4).tolist(), "scene": "x", "settings": {"semi": [1.0, 2.0]}}
    one = np.eye(6) * 1e-9
    square, line = np.eye(4) * 1e-10, np.full((4, 3), 1e-11)
    bodies = CondensedBodies("0" * 16, 1, np.arange(4.0), 0.1, one, one, square, line, line * 1e12, np.full(4, 1e-7))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bodies.npz"
        bodies.save(path)
        kinds = (
            ("stored run", run_text_with_checksum(run).encode(), lambda: read_checked_data(path) == run),
            ("stored bodies", path.read_bytes(), lambda: _same(read_condensed_bodies(path), bodies)),
        )
        for number in range(count):
            kind, good, read = kinds[number % 2]
            path.write_bytes(mutated(good, np.random.default_rng([seed, 2, number])))
            yield _outcome(kind, read, ValueError)


def _same(a: CondensedBodies, b: CondensedBodies) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(vars(a).values(), vars(b).values(), strict=True))


def kills(seed: int, count: int) -> Iterator[FileOutcome]:
    """A process that writes a file again and again is killed: the file is whole, and the next writer clears up."""
    rng = np.random.default_rng([seed, 3])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path[1:])}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "written.txt"
        words = [sys.executable, "-P", "-c", WRITER, str(path)]
        for _ in range(count):
            with subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
                child.stdout.readline()
                sleep(float(rng.uniform(0.0, 0.05)))
                child.kill()
            text = path.read_text(encoding="utf-8") if path.exists() else ""
            whole = text == "" or (len(text) == 400_000 and len(set(text)) == 1)
            replace_file(path, text)  # the next writer
            left = [p.name for p in Path(folder).iterdir() if p != path]
            yield FileOutcome("kill", "whole" if whole else "half-written", whole and not left, ", ".join(left))


def tally(outcomes: list[FileOutcome]) -> dict[str, dict[str, int]]:
    """How many outcomes of each verdict by kind, and how many are bad."""
    out: dict[str, dict[str, int]] = defaultdict(Counter)
    for o in outcomes:
        out[o.kind].update({o.verdict: 1, "bad": int(not o.good)})
    return out
