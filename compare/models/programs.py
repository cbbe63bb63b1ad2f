"""Low-order models of users as programs in any language: a command that reads a scene as JSON and writes loads as CSV.

``prog {scene.json} {loads.csv}`` is run for every scene in the current folder, without a shell, with two paths in place of
the braces. Such a command can be given wherever a model is named; ``{seconds=600}`` in it is its time limit (see
`model_command`).
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

#: Placeholders of the two files in a command, and of its time limit.
SCENE, LOADS, LIMIT = "{scene.json}", "{loads.csv}", re.compile(r"\{seconds=([^{}]*)\}")
#: Default and largest time limit of a program for one scene [s].
SECONDS, LONGEST = 60.0, 1e6
#: Contact loads below this [N] are round-off and set to zero.
LEAST = 1e-9
#: Name of the note in the file of loads that gives the displacement of the screw at the nut's centre.
DISPLACEMENT = "displacement"
#: Bytes at the end of a program's output that are searched for its last line.
TAIL = 4096
MEND = "run it by hand on what rollbench export SCENE --format json writes; `model_seconds` gives it more time"


def is_command(name: str) -> bool:
    """Return whether the name of a model is a command.

    Parameters
    ----------
    name
        Name of a model, or a command.
    """
    return SCENE in name or LOADS in name


def model_command(command: str, seconds: float = SECONDS) -> str:
    """Return the model name that stands for the command of a program; every function that takes a model accepts it.

    Parameters
    ----------
    command
        Program and its arguments, with ``{scene.json}`` for the file that it reads and ``{loads.csv}`` for the file that it
        writes, each once.
    seconds
        Time limit for one scene [s], at most 1e6.

    Returns
    -------
    str
        The name: ``rollbench.solve(scene, rollbench.model_command("./mine {scene.json} {loads.csv}"))``.

    Raises
    ------
    rollbench.InputError
        If a file is missing in the command, its quotes do not match, or the time limit is out of range.

    Examples
    --------
    >>> model_command("awk -f share.awk {scene.json} {loads.csv}", seconds=600)
    'awk -f share.awk {scene.json} {loads.csv} {seconds=600}'
    """
    name = command if seconds == SECONDS else f"{command} {{seconds={seconds:g}}}"
    parse_command(name)
    return name


def title_of(name: str) -> str:
    """Return the name of a model for headings; for a command, its words without folders and placeholders.

    Parameters
    ----------
    name
        Name of a model, or a command.

    Returns
    -------
    str
        The heading.

    Examples
    --------
    >>> title_of("awk -f /home/me/share.awk {scene.json} {loads.csv}"), title_of("lin")
    ('awk -f share.awk', 'lin')
    """
    return parse_command(name).label if is_command(name) else name


@cache
def parse_command(name: str) -> Program:
    """Split a command into a program and its time limit.

    Parameters
    ----------
    name
        The command.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    ArgumentError
        If a file is missing in the command, its quotes do not match, or the time limit is out of range.
    """
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
    """Program of a user that serves as a model: command and time limit."""

    words: tuple[str, ...]
    """Words of the command, with placeholders for the files."""
    seconds: float
    """Time limit for one scene [s]."""

    @property
    def label(self) -> str:
        """Words of the command without placeholders, paths shortened to the file name."""
        words = [Path(word).name or word for word in self.words if SCENE not in word and LOADS not in word]
        return one_line(" ".join(words), 40)

    @property
    def files(self) -> str:
        """Names of the files in the command, each with a digest of its contents, to recognise a changed program."""
        import hashlib

        paths = [Path(shutil.which(self.words[0]) or self.words[0]), *map(Path, self.words[1:])]
        found = [f"{p.name} {hashlib.sha256(p.read_bytes()).hexdigest()[:16]}" for p in paths if p.is_file()]
        return ", ".join(found)

    def __call__(self, scene: Scene) -> tuple[GivenLoads, Array | None]:
        """Run the program for a scene, in a temporary folder.

        Parameters
        ----------
        scene
            Scene, whose random errors are drawn.

        Returns
        -------
        tuple
            Loads, and the displacement of the screw (6,) [m, rad] or None.

        Raises
        ------
        ProgramError
            If the program cannot be started, exits with another code than 0, exceeds its time limit, or does not write the
            loads of every contact.
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
        """Run the program with its output sent to a file; return why it failed, else an empty text."""
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
                _kill_process(process)
        return "" if code == 0 else f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"

    def _failed(self, scene: Scene, why: str, said: Path) -> ProgramError:
        """Return the error for a program that failed, with the last line that it printed."""
        line = last_line(said)
        words = "" if line is None else f"; its last line: {line}" if line else "; it printed nothing"
        return ProgramError(self.label, scene.name, why + words, MEND)

    def _read(self, path: Path, scene: Scene) -> tuple[GivenLoads, Array | None]:
        """Return the loads and the displacement in a file; InputError if they cannot be used."""
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


def _kill_process(process: subprocess.Popen[bytes]) -> None:
    """Kill a program that is still running, with all processes that it started."""
    if process.poll() is None:
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        process.wait()


def last_line(path: Path) -> str | None:
    """Return the last non-empty line of a program's output.

    Parameters
    ----------
    path
        File with the output.

    Returns
    -------
    str or None
        The line, empty if nothing was printed; None if there is no such file.
    """
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - TAIL))
            lines = file.read().decode("utf-8", errors="replace").split("\n")
    except OSError:
        return None
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def scene_json(scene: Scene) -> str:
    """Return a scene as JSON for a program, in SI units.

    Parameters
    ----------
    scene
        The scene, whose random errors are drawn.

    Returns
    -------
    str
        Fields of the scene; under ``given`` the lead angle [rad] and the axial force of all loads [N]; under ``contacts``
        for every ball its azimuth [rad] and axial position [m], the closures of both pairs of flanks by all errors in the
        nominal position [m] (positive: pressed), and the Hertz constants C [m/N^(2/3)] of its contacts.
    """
    from rollbench.lowfi.statics.contacts import error_free, hertz_C
    from rollbench.lowfi.statics.problem import centre_distances

    layout = ball_layout(scene)
    drawn = specimen(scene, layout)
    _, closure = centre_distances(scene, drawn)
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
