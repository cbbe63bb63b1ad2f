"""External programs as low-order models: a command that reads a scene as JSON and writes contact loads as CSV.

For every scene, a command such as ``prog {scene.json} {loads.csv}`` is run in the current folder, without a shell, after
the two placeholders were replaced by paths. Only a `ModelCommand`, which `model_command` returns, runs a program, never a
name; ``{seconds=600}`` in it is its time limit.
"""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError, ProgramError, one_line
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import SIDES, Scene

if TYPE_CHECKING:
    import subprocess

    from rollbench.compare.models.loads_file import ContactLoadsFromFile

#: Placeholders in a command: for the file with the scene, for the file with the loads, and for the time limit.
SCENE, LOADS, LIMIT = "{scene.json}", "{loads.csv}", re.compile(r"\{seconds=([^{}]*)\}")
#: Default and largest time limit of a program for one scene [s].
SECONDS, LONGEST = 60.0, 1e6
#: Contact loads below this [N] are round-off and set to zero.
LEAST = 1e-9
#: Name of the comment in the program's CSV file that gives the displacement of the screw at the nut's centre.
DISPLACEMENT = "displacement"
#: Bytes at the end of a program's output that are searched for its last line.
TAIL = 4096
#: Advice in the error message for a program that failed.
MEND = "run the program by hand on a file of `rollbench export SCENE --format json`; for more time, set `model_seconds`"


class ModelCommand(str):
    """Command that runs an external program as a model; `model_command` makes it. A text of the same words runs nothing."""

    __slots__ = ()


def is_program_command(name: str) -> bool:
    """Return whether a model is a command that runs an external program.

    Parameters
    ----------
    name
        Name of a model, or a `ModelCommand`.
    """
    return isinstance(name, ModelCommand)


def model_command(command: str, seconds: float = SECONDS) -> ModelCommand:
    """Return the model that runs an external program; any function with an argument ``model`` takes it.

    Parameters
    ----------
    command
        Program and its arguments, with ``{scene.json}`` for the file that it reads and ``{loads.csv}`` for the file that it
        writes, each once.
    seconds
        Time limit for one scene [s], at most 1e6.

    Returns
    -------
    ModelCommand
        The model: ``rollbench.solve(scene, rollbench.model_command("./mine {scene.json} {loads.csv}"))``. A text of the
        same words in place of it is refused.

    Raises
    ------
    rollbench.InputError
        If a placeholder is missing in the command, its quotation marks do not match, or the time limit is out of range.

    Examples
    --------
    >>> model_command("awk -f share.awk {scene.json} {loads.csv}", seconds=600)
    'awk -f share.awk {scene.json} {loads.csv} {seconds=600}'
    """
    name = command if seconds == SECONDS else f"{command} {{seconds={seconds:g}}}"
    parse_command(name)
    return ModelCommand(name)


def model_title(name: str) -> str:
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
    >>> model_title(model_command("awk -f /home/me/share.awk {scene.json} {loads.csv}")), model_title("lin")
    ('awk -f share.awk', 'lin')
    """
    return parse_command(name).short_name if is_program_command(name) else name


@cache
def parse_command(name: str) -> ExternalProgram:
    """Check the command of an external program, and split it into its words and its time limit.

    Parameters
    ----------
    name
        The command.

    Returns
    -------
    ExternalProgram
        Record of the words and the time limit.

    Raises
    ------
    ArgumentError
        If a placeholder is missing in the command, its quotation marks do not match, or the time limit is out of range.
    """
    advice = f'give the whole command as one text, such as "./prog {SCENE} {LOADS}"'
    limit = LIMIT.search(name)
    command = LIMIT.sub("", name).strip()
    for file in (SCENE, LOADS):
        if command.count(file) != 1:
            allowed = f"a command that contains the placeholder {file} once"
            raise ArgumentError("model_command", command or "nothing", allowed, advice)
    try:
        words = tuple(shlex.split(command, posix=os.name != "nt"))
    except ValueError as error:
        raise ArgumentError("model_command", command, f"a command that can be split into words ({error})", advice) from None
    if not words or SCENE in words[0] or LOADS in words[0]:
        raise ArgumentError("model_command", command, "a command that begins with a program", advice)
    try:
        seconds = SECONDS if limit is None else float(limit[1])
    except ValueError:
        seconds = math.nan
    if limit is not None and not 0.0 < seconds <= LONGEST:
        allowed = f"above 0 and up to {LONGEST:g} seconds"
        raise ArgumentError("model_seconds", limit[1] or "nothing", allowed, "write 600 for ten minutes")
    return ExternalProgram(words, seconds)


@dataclass(frozen=True)
class ExternalProgram:
    """Command of an external program that serves as a low-order model, with its time limit."""

    command_words: tuple[str, ...]
    """Words of the command, with placeholders for the file of the scene and the file of the loads."""
    time_limit: float
    """Time limit for one scene [s]."""

    @property
    def short_name(self) -> str:
        """Short name of the program: its command without placeholders and without the folders in paths."""
        words = [Path(word).name or word for word in self.command_words if SCENE not in word and LOADS not in word]
        return one_line(" ".join(words), 40)

    @property
    def file_names_with_hashes(self) -> str:
        """Names of the files in the command, each with a hash of its contents, which changes with the program."""
        import hashlib

        paths = [Path(shutil.which(self.command_words[0]) or self.command_words[0]), *map(Path, self.command_words[1:])]
        found = [f"{p.name} {hashlib.sha256(p.read_bytes()).hexdigest()[:16]}" for p in paths if p.is_file()]
        return ", ".join(found)

    def __call__(self, scene: Scene) -> tuple[ContactLoadsFromFile, Array | None]:
        """Run the program for a scene, with its input and output files in a temporary folder.

        Parameters
        ----------
        scene
            Scene with geometric errors that are fixed values, not random.

        Returns
        -------
        ContactLoadsFromFile
            Contact loads.
        Array or None
            Displacement of the screw at the nut's centre, (6,) [m, rad]; None if the program writes no displacement.

        Raises
        ------
        ProgramError
            If the program cannot be started, exits with a code other than 0, exceeds its time limit, or does not write the
            load of every contact.
        """
        import tempfile

        with tempfile.TemporaryDirectory(prefix="rollbench-", ignore_cleanup_errors=True) as name:
            folder = Path(name)
            asked, loads, said = (folder / x for x in ("scene.json", "loads.csv", "output"))
            asked.write_text(scene_json(scene), encoding="utf-8")
            words = [word.replace(SCENE, str(asked)).replace(LOADS, str(loads)) for word in self.command_words]
            try:
                why = self._run_and_explain_failure(words, said)
                if why:
                    raise self._failure_error(scene, why, said)
                if not loads.exists():
                    raise self._failure_error(scene, f"wrote no {LOADS}", said)
                return self._read_loads_and_displacement(loads, scene)
            except InputError as error:
                if isinstance(error, ProgramError):
                    raise
                what = f"{error.key}: {error.value or 'nothing'}; allowed: {error.allowed}"
                raise self._failure_error(scene, f"wrote loads that cannot be used, {what}", said) from None

    def _run_and_explain_failure(self, command_words: list[str], output_file: Path) -> str:
        """Run the program, and return why it failed; empty if it ended with exit code 0 within its time limit.

        ``command_words``: words of the command with the paths of its files; ``output_file``: file that takes its printed
        output.
        """
        import subprocess

        with output_file.open("wb") as output:
            try:
                process = subprocess.Popen(
                    command_words, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
                )
            except OSError as error:
                output_file.unlink()
                return f"cannot be started: {error.strerror or error}"
            with _killed_when_this_process_ends(process):
                try:
                    code = process.wait(self.time_limit)
                except subprocess.TimeoutExpired:
                    return f"was ended after its time limit of {self.time_limit:g} s"
                finally:
                    _kill_process(process)
        return "" if code == 0 else f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"

    def _failure_error(self, scene: Scene, reason: str, output_file: Path) -> ProgramError:
        """Return the ProgramError for this program's failure on a scene, with the last line that it printed.

        ``reason``: reason of the failure; ``output_file``: file with the program's printed output.
        """
        line = last_printed_line(output_file)
        words = "" if line is None else f"; its last line: {line}" if line else "; it printed nothing"
        return ProgramError(self.short_name, scene.name, reason + words, MEND)

    def _read_loads_and_displacement(self, path: Path, scene: Scene) -> tuple[ContactLoadsFromFile, Array | None]:
        """Read the contact loads and the displacement of the screw at the nut's centre from the program's output file.

        ``path``: the file. The displacement (6,) [m, rad] is None if the program wrote none. InputError if loads or
        displacement cannot be used.
        """
        from rollbench.compare.models.loads_file import read_loads

        given = read_loads(path, scene)
        given.load[given.load < LEAST] = 0.0
        lacking = [side for side in SIDES if side not in given.flanks_with_rows]
        if lacking:
            allowed = "loads of every ball on the left and right flanks of screw (SL, SR) and nut (NL, NR)"
            raise InputError(LOADS, "rows", f"no rows for {', '.join(lacking)}", allowed, "")
        note = given.notes.get(DISPLACEMENT)
        if note is None:
            return given, None
        try:
            moved = np.array([float(x) for x in note.replace(",", " ").split()])
        except ValueError:
            moved = np.zeros(0)
        if moved.shape != (6,) or not np.isfinite(moved).all():
            allowed = "six numbers ux uy uz [m] rx ry rz [rad]: displacement and rotation of the screw at the nut's centre"
            raise InputError(LOADS, f"line # {DISPLACEMENT}", note, allowed, "")
        return given, moved


@contextmanager
def _killed_when_this_process_ends(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """While the context lasts, have a program and all that it started killed when this process ends, however it ends.

    A shell waits for the end of a pipe of which this process holds the other end, and then kills the program's group.
    """
    import subprocess

    if not hasattr(os, "killpg"):
        yield
        return
    words, none = ["/bin/sh", "-c", "read -r _; kill -s KILL -- -$0", str(process.pid)], subprocess.DEVNULL
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=none, stderr=none, start_new_session=True) as guard:
        try:
            yield
        finally:
            guard.kill()


def _kill_process(process: subprocess.Popen[bytes]) -> None:
    """Kill an external program that is still running, with all processes that it started."""
    if process.poll() is None:
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        process.wait()


def last_printed_line(path: Path) -> str | None:
    """Return the last non-empty line that an external program printed.

    Parameters
    ----------
    path
        File with the output.

    Returns
    -------
    str or None
        The line, empty if nothing was printed; None if the file does not exist.
    """
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - TAIL))
            lines = file.read().decode("utf-8", errors="replace").split("\n")
    except OSError:
        return None
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def scene_json(scene: Scene) -> str:
    """Return a scene as JSON in SI units, as an external program reads it.

    Parameters
    ----------
    scene
        Scene with geometric errors that are fixed values, not random.

    Returns
    -------
    str
        JSON with the fields of the scene. The key ``given`` has the lead angle [rad] and the axial force of all loads [N].
        The key ``contacts`` has for every ball: azimuth [rad], axial position [m], the interference [m] that all errors
        cause on both pairs of flanks in the nominal position (positive: pressed), and the Hertz constants C [m/N^(2/3)] of
        its contacts, where the approach under the load F is C F^(2/3).
    """
    from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice, scene_with_error_free_hertz
    from rollbench.lowfi.statics.problem import place_balls

    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout)
    closure = place_balls(scene, drawn).interference
    C = hertz_constants_by_scene_choice(scene_with_error_free_hertz(scene), drawn)
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
