"""A user's low-order model as a program of any language: a command that reads a scene as JSON and writes loads as CSV.

``prog {scene.json} {loads.csv}`` is run for every scene with two paths in place of the braces, without a shell, in the
folder where rollbench was called. Such a command stands wherever the name of a model does, so it reaches every worker as
text; ``{seconds=600}`` in it is its limit of time (`model_command` writes it).
"""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import shutil
import signal
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError, ProgramError, one_line
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import SIDES, Scene

if TYPE_CHECKING:
    import subprocess

    from rollbench.compare.models.loads_file import GivenLoads

#: What stands for the two files in a command, and for its limit of time.
SCENE, LOADS, LIMIT = "{scene.json}", "{loads.csv}", re.compile(r"\{seconds=([^{}]*)\}")
#: Seconds that a program has for a scene unless it is given others, and the most that it may be given.
SECONDS, LONGEST = 60.0, 1e6
#: Least load of a contact [N]: what a program leaves below it is round-off.
LEAST = 1e-9
#: Note of the loads' file that gives the motion of the screw at the nut's centre.
DISPLACEMENT = "displacement"
#: Bytes of a program's output in which its last line is looked for.
TAIL = 4096
MEND = "run it by hand on what rollbench export SCENE --format json writes; `model_seconds` gives it more time"


def is_command(name: str) -> bool:
    """Whether a model is named by a command."""
    return SCENE in name or LOADS in name


def model_command(command: str, seconds: float = SECONDS) -> str:
    """The name of a program as a model, for every function that takes one: ``solve(scene, model_command(...))``.

    command: its words, ``{scene.json}`` and ``{loads.csv}`` in place of the files that it reads and writes; seconds: its
    limit of time for a scene. Raises InputError where one of them cannot be.
    """
    name = command if seconds == SECONDS else f"{command} {{seconds={seconds:g}}}"
    program(name)
    return name


def title_of(name: str) -> str:
    """The name of a model in words: of a command its words without folders and files.

    >>> title_of("awk -f /home/me/share.awk {scene.json} {loads.csv}"), title_of("lin")
    ('awk -f share.awk', 'lin')
    """
    return program(name).label if is_command(name) else name


@cache
def program(name: str) -> Program:
    """The program of a command. Raises InputError for one without its files, with quotes that do not fit, or a time that is
    none."""
    advice = f'give its words in one text: "./prog {SCENE} {LOADS}"'
    limit = LIMIT.search(name)
    command = LIMIT.sub("", name).strip()
    for file in (SCENE, LOADS):
        if command.count(file) != 1:
            raise ArgumentError("model_command", command or "nothing", f"{file} once", advice)
    try:
        words = tuple(shlex.split(command, posix=os.name != "nt"))
    except ValueError as error:
        raise ArgumentError("model_command", command, f"words of a command ({error})", advice) from None
    if not words or SCENE in words[0] or LOADS in words[0]:
        raise ArgumentError("model_command", command, "a program before its files", advice)
    try:
        seconds = SECONDS if limit is None else float(limit[1])
    except ValueError:
        seconds = math.nan
    if limit is not None and not 0.0 < seconds <= LONGEST:
        raise ArgumentError("model_seconds", limit[1] or "nothing", f"above 0 to {LONGEST:g}", "600 are ten minutes")
    return Program(words, seconds)


@dataclass(frozen=True)
class Program:
    """A program as a model: the words of its command and its limit of time [s] for a scene."""

    words: tuple[str, ...]
    seconds: float

    @property
    def label(self) -> str:
        """Its words without those of the files, paths by their last part."""
        words = [Path(word).name or word for word in self.words if SCENE not in word and LOADS not in word]
        return one_line(" ".join(words), 40)

    @property
    def files(self) -> str:
        """Files that the command names, with a digest of what they hold: whether it is the same program as before."""
        import hashlib

        paths = [Path(shutil.which(self.words[0]) or self.words[0]), *map(Path, self.words[1:])]
        found = [f"{p.name} {hashlib.sha256(p.read_bytes()).hexdigest()[:16]}" for p in paths if p.is_file()]
        return ", ".join(found)

    def __call__(self, scene: Scene) -> tuple[GivenLoads, Array | None]:
        """What the program answers a scene, whose errors are all drawn: loads, and the motion of the screw ``(6,)``
        [m, rad] where it says one.

        Its files lie in a folder of their own, which goes with the call however that ends. Raises ProgramError where the
        program cannot be started, ends with another exit code than 0, is late, or writes no loads of every contact.
        """
        import tempfile

        with tempfile.TemporaryDirectory(prefix="rollbench-", ignore_cleanup_errors=True) as name:
            folder = Path(name)
            asked, loads, said = (folder / x for x in ("scene.json", "loads.csv", "output"))
            asked.write_text(scene_json(scene), encoding="utf-8")
            words = [word.replace(SCENE, str(asked)).replace(LOADS, str(loads)) for word in self.words]
            try:
                why = self._run(words, said)
                if why:
                    raise self._failed(scene, why, said)
                if not loads.exists():
                    raise self._failed(scene, f"wrote no {LOADS}", said)
                return self._read(loads, scene)
            except InputError as error:
                if isinstance(error, ProgramError):
                    raise
                what = f"{error.key}: {error.value or 'nothing'}; allowed: {error.allowed}"
                raise self._failed(scene, f"wrote loads that cannot be used, {what}", said) from None

    def _run(self, words: list[str], said: Path) -> str:
        """Run the program with its output in a file; why it did not end well, empty where it did."""
        import subprocess

        with said.open("wb") as output:
            try:
                process = subprocess.Popen(
                    words, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
                )
            except OSError as error:
                said.unlink()
                return f"cannot be started: {error.strerror or error}"
            try:
                code = process.wait(self.seconds)
            except subprocess.TimeoutExpired:
                return f"was ended after {self.seconds:g} s, its limit of time"
            finally:
                _end(process)
        return "" if code == 0 else f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"

    def _failed(self, scene: Scene, why: str, said: Path) -> ProgramError:
        """What is said of a program that did not answer, with its last line."""
        line = last_line(said)
        words = "" if line is None else f"; its last line: {line}" if line else "; it printed nothing"
        return ProgramError(self.label, scene.name, why + words, MEND)

    def _read(self, path: Path, scene: Scene) -> tuple[GivenLoads, Array | None]:
        """The answer of a file. Raises InputError."""
        from rollbench.compare.models.loads_file import read_loads

        given = read_loads(path, scene.ball_count, scene)
        given.load[given.load < LEAST] = 0.0
        lacking = [side for side in SIDES if side not in given.flanks]
        if lacking:
            raise InputError(LOADS, "rows", f"no loads on {', '.join(lacking)}", "every ball on SL, SR, NL and NR", "")
        note = given.notes.get(DISPLACEMENT)
        if note is None:
            return given, None
        try:
            moved = np.array([float(x) for x in note.replace(",", " ").split()])
        except ValueError:
            moved = np.zeros(0)
        if moved.shape != (6,) or not np.isfinite(moved).all():
            raise InputError(LOADS, f"# {DISPLACEMENT}", note, "ux uy uz [m] rx ry rz [rad]", "")
        return given, moved


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a program that is still at work, with all that it started."""
    if process.poll() is None:
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        process.wait()


def last_line(path: Path) -> str | None:
    """The last line of a program's output, empty where it printed none; None where it was not run."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - TAIL))
            lines = file.read().decode("utf-8", errors="replace").split("\n")
    except OSError:
        return None
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def scene_json(scene: Scene) -> str:
    """A scene as JSON for a program, SI units: its fields, and what a low-order model is made of.

    Under ``given`` the lead angle [rad] and the axial force of all loads [N]; under ``contacts`` of every ball (a row a
    line) azimuth [rad] and station [m], closures [m] of its two pairs of flanks in the nominal place by all errors
    (positive: pressed), and Hertz's constants C [m/N^(2/3)] of its contacts: approach C F^(2/3).
    """
    from rollbench.lowfi.statics.contacts import error_free, hertz_C
    from rollbench.lowfi.statics.problem import distances

    layout = ball_layout(scene)
    drawn = specimen(scene, layout)
    _, closure = distances(scene, drawn)
    C = hertz_C(error_free(scene), drawn)
    balls = [
        {"ball": i + 1, "azimuth": float(layout.azimuth[i]), "z": float(layout.z[i])}
        | {"closure_SL_NR": float(closure[i, 0]), "closure_SR_NL": float(closure[i, 1])}
        | {f"C_{side}": float(C[i, s]) for s, side in enumerate(SIDES)}
        for i in range(scene.ball_count)
    ]
    axial = float(sum(load.force[2] for load in scene.loads))
    given = {"lead_angle": lead_angle(scene.track), "axial_force": axial}
    head = {"rollbench": __version__, "units": "SI: m, N, rad, Pa", **asdict(scene), "given": given}
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in head.items()]
    rows = ",\n".join(json.dumps(ball) for ball in balls)
    return "{\n" + ",\n".join(lines) + f',\n"contacts": [\n{rows}\n]\n}}\n'
