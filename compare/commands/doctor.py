"""Command ``doctor``, which checks this computer for what rollbench needs, and ``completion`` of commands by the shell."""

from __future__ import annotations

import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Literal

from rollbench.compare import __version__
from rollbench.compare.commands.terminal import Flag, Json, app
from rollbench.compare.running import available_GB, gmsh_fault, gmsh_install_advice, usable_cores
from rollbench.compare.text.printing import CommandOutput, guard_standard_output, print_command_output

#: Outcome of a check of the computer.
State = Literal["ok", "missing", "optional"]

#: Oldest supported version of Python.
PYTHON = (3, 11, 2)

#: Licences of packages that impose conditions on those who distribute the package together with rollbench.
STRICT = {"gmsh": "GPL-2.0-or-later, with exceptions for linking"}

#: Text on the licences of rollbench and of the packages that it imports.
LICENCES = (
    "The code of rollbench is under the MIT licence. It imports gmsh, which is under the GNU GPL: whoever distributes it "
    "together with gmsh must comply with the GPL. Only the 3D reference imports gmsh."
)

#: Memory [GB] for a run of the 3D reference on mesh level 1 for a screw with 32 balls, and disc space [GB] for caches.
ENOUGH_GB, DISC_GB = 4.0, 2.0

#: Other programs: names of the command, purpose, Debian package.
PROGRAMS = {
    "ccx": (("ccx",), "solution with CalculiX by rollbench crosscheck --run", "calculix-ccx"),
    "chromium": (("chromium", "chromium-browser", "google-chrome"), "tests of the report in a browser", "chromium"),
}


@dataclass(frozen=True)
class MachineCheck:
    """Result of one check of the computer, such as whether a package is installed."""

    #: Name of the check, such as the package.
    name: str
    #: Outcome: "ok", "missing", or "optional" if the checked item is missing but not needed.
    state: State
    #: Text on what was found, such as the version of a package, or on what is missing.
    found: str
    #: Effect if the checked item is missing; empty if nothing is missing.
    cost: str = ""
    #: What the user should do; empty if nothing is missing.
    advice: str = ""

    def line(self) -> str:
        """Return the result of the check as one line of text."""
        return f"{self.state:8}  " + "; ".join(filter(None, (f"{self.name}: {self.found}", self.cost, self.advice)))


def _result_of_check(
    name: str, found: str, fault: str, effect: str, advice: str, state_if_faulty: State = "missing"
) -> MachineCheck:
    """Return the result of a check of the computer: "ok" without a ``fault``, else ``state_if_faulty``.

    ``name``: name of the check. ``found``: what was found, if nothing is wrong. ``fault``: what is missing or wrong; empty:
    nothing. ``effect``: effect of the fault. ``advice``: remedy.
    """
    return MachineCheck(name, state_if_faulty, fault, effect, advice) if fault else MachineCheck(name, "ok", found)


def _check_python() -> Iterator[MachineCheck]:
    """Yield the check whether the version of Python is supported."""
    present, least = platform.python_version(), ".".join(map(str, PYTHON))
    old = sys.version_info[:3] < PYTHON
    lack, advice = present if old else "", f"install Python {least} or newer"
    yield _result_of_check("Python", f"{present}, at least {least}", lack, "not supported", advice)


def oldest_package_versions() -> dict[str, str]:
    """Return the oldest supported version of each package that rollbench and its extras need, by name of the package.

    The dictionary is empty if rollbench itself is not installed.
    """
    from rollbench.meshes.libraries import EXTRA

    try:
        lines = metadata.requires("rollbench") or []
    except metadata.PackageNotFoundError:
        return {}
    bounds = (re.fullmatch(r"([\w.-]+)\s*>=\s*([\d.]+)(?:; extra == .(\w+).)?", line.strip()) for line in lines)
    return {bound[1]: bound[2] for bound in bounds if bound and (bound[3] is None or EXTRA.get(bound[1]) == bound[3])}


def _check_packages() -> Iterator[MachineCheck]:
    """Yield for each Python package that rollbench or its extras need the check whether it is installed and new enough."""
    from rollbench.meshes.libraries import EXTRA, ONLY_FOR, installed_version, pip_command, reason_of_failed_import

    needed = oldest_package_versions()
    if not needed:
        effect, advice = "versions of packages are not known", "install it by pip install ."
        yield MachineCheck("rollbench", "missing", "not installed", effect, advice)
    for name, least in needed.items():
        present, wanted, lack = installed_version(name), f"'{name}>={least}'", ""
        state: State = "missing"
        advice, licence = f"pip install {wanted}", f" ({STRICT[name]})" if name in STRICT else ""
        if present is None:
            lack = "not installed"
            if name in EXTRA:
                advice, state = pip_command(name), "optional"
        elif _version_numbers(present) < _version_numbers(least):
            lack = f"{present}, older than {least}"
        elif name != "gmsh" and (broken := reason_of_failed_import(name)):  # gmsh: see `_check_graphics`
            lack, advice = f"{present}, {broken}", f"pip install --force-reinstall {wanted}"
        cost = ONLY_FOR.get(name, "rollbench does not run")
        yield _result_of_check(name, f"{present}, at least {least}{licence}", lack, cost, advice, state)


def _version_numbers(version: str) -> tuple[int, ...]:
    """Return the numbers at the start of a version text, so that versions can be compared.

    Examples
    --------
    >>> _version_numbers("4.15.2rc1") > _version_numbers("4.13")
    True
    """
    return tuple(int(number) for number in re.findall(r"\d+", re.split(r"[^\d.]", version)[0]))


def _check_graphics() -> Iterator[MachineCheck]:
    """Yield the checks whether gmsh can be loaded and whether 3D pictures can be drawn without a screen."""
    from rollbench.meshes.libraries import ONLY_FOR, PICTURES, apt_command, installed_version
    from rollbench.reports import offscreen

    if installed_version("gmsh"):
        yield _result_of_check("meshing", "gmsh loads", gmsh_fault(), ONLY_FOR["gmsh"], gmsh_install_advice())
    if installed_version("pyvista"):
        lack, cost = offscreen.reason_drawing_fails(), ONLY_FOR["pyvista"]
        yield _result_of_check("off-screen rendering", "a picture was drawn", lack, cost, apt_command(PICTURES))


def _check_programs() -> Iterator[MachineCheck]:
    """Yield for each optional external program (CalculiX, a browser) the check whether it is installed."""
    for name, (commands, purpose, package) in PROGRAMS.items():
        path = next(filter(None, map(shutil.which, commands)), "")
        lack, advice = "" if path else "not found", f"apt-get install {package}"
        yield _result_of_check(name, path, lack, f"without it, no {purpose}", advice, "optional")


def _check_folders(store: Path) -> Iterator[MachineCheck]:
    """Yield the checks whether meshes and runs of the 3D reference can be stored in their folders."""
    from rollbench.meshes.cache import default_cache_folder

    root = default_cache_folder()
    name, cost = "cache of meshes", "meshes are built every time"
    if root is None:
        yield MachineCheck(name, "optional", "switched off", cost, "unset ROLLBENCH_CACHE")
    else:
        yield _check_folder(name, root, cost, "name another folder by ROLLBENCH_CACHE")
    advice = "name another folder by --store"
    yield _check_folder("store of references", store, "no run of the 3D reference can be stored", advice)


def _check_folder(name: str, folder: Path, cost: str, advice: str) -> MachineCheck:
    """Return the check whether a folder can be written to and has at least `DISC_GB` of free space.

    ``name``: name of the check. ``cost``: effect if it cannot be used. ``advice``: remedy. A folder that does not exist is
    checked at its nearest existing parent.
    """
    from rollbench.compare.errors import InputError
    from rollbench.compare.files import check_writable

    near = folder
    while not near.exists() and near != near.parent:
        near = near.parent
    try:
        lack = "" if near.is_dir() else f"{near} is no folder"
        if not lack:
            check_writable(near / "rollbench-probe")
    except InputError as error:
        lack = f"{folder}: {error.value}"
    free = 0.0 if lack else 1e-9 * shutil.disk_usage(near).free
    if not lack and free < DISC_GB:
        lack, advice = f"{folder}: {free:.1f} GB free", f"free at least {DISC_GB:g} GB"
    return _result_of_check(name, f"{folder} can be written to, {free:.0f} GB free", lack, cost, advice)


def _check_memory() -> Iterator[MachineCheck]:
    """Yield an entry with the number of processor cores, then the check whether enough memory is free for a 3D run."""
    yield MachineCheck("cores", "ok", f"{usable_cores()} of {os.cpu_count()} for this process")
    free = available_GB()
    if free is None:
        yield MachineCheck("memory", "optional", "not known on this system", "3D runs start without a check of the memory")
        return
    room = f"{free:.1f} GB free; a 3D run of 64 contacts takes up to {ENOUGH_GB:g} GB"
    lack = f"{free:.1f} GB free" if free < ENOUGH_GB else ""
    cost = f"a 3D run of 64 contacts needs {ENOUGH_GB:g} GB"
    yield _result_of_check("memory", room, lack, cost, "close other programs, or use a computer with more memory")


def _check_shipped_runs() -> Iterator[MachineCheck]:
    """Yield the check whether the runs of the 3D reference that are shipped with rollbench are complete."""
    from rollbench.compare.reference.estimate import reference_of_scene
    from rollbench.compare.reference.store import PROGRAMS
    from rollbench.compare.scenes import catalogue

    names = catalogue.names_of_scenes_with_role("referenced")
    held = [kept for name in names if (kept := reference_of_scene(catalogue.scene(name))) is not None]
    programs = ", ".join(
        f"{program} {' and '.join(sorted({run.versions[program] for kept in held for run in kept.runs}))}"
        for program in PROGRAMS
    )
    lack = "" if len(held) == len(names) else f"for {len(held)} of {len(names)} scenes, computed by {programs}"
    found, cost = f"for all {len(names)} scenes, computed by {programs}", "the others are recomputed, which takes hours"
    yield _result_of_check("shipped references", found, lack, cost, "reinstall rollbench")


@app.command
def doctor(*, store: Path = Path("rollbench-reference"), as_json: Json = False) -> int:
    """Check this computer for all that rollbench needs, and list what is missing and which effect this has.

    The checks are of Python packages, system libraries, rendering, folders, memory and licences. Exit codes: 0 nothing is
    missing (optional programs and packages do not count), 1 something is missing.

    Parameters
    ----------
    store
        Folder of stored runs of the 3D reference.
    """
    checks = [*_check_python(), *_check_packages(), *_check_graphics(), *_check_programs()]
    checks += [*_check_folders(store), *_check_memory(), *_check_shipped_runs()]
    lacking = [check for check in checks if check.state == "missing"]
    rows = [asdict(check) for check in checks]
    data = {"rollbench": __version__, "complete": not lacking, "checks": rows, "licences": LICENCES}
    end = f"{len(lacking)} missing" if lacking else "nothing is missing"
    parts = [f"rollbench {__version__}", *(check.line() for check in checks), end, LICENCES]
    return print_command_output(CommandOutput(data, parts, 1 if lacking else 0), as_json)


@app.command
def completion(shell: Literal["bash", "zsh", "fish"], *, install: Flag = False) -> None:
    """Print the script by which a shell completes the commands and options of rollbench, or install this script.

    Parameters
    ----------
    shell
        bash, zsh or fish.
    install
        Write the script to the place in the home folder where the shell looks for it, and print the path.
    """
    text = app.generate_completion(prog_name="rollbench", shell=shell)
    if install:
        path = app.install_completion(shell=shell)
        print_command_output(CommandOutput(texts_and_tables=[f"wrote {path}; the completion works in a new shell"]))
    else:
        with guard_standard_output():
            sys.stdout.write(f"{text}\n")
