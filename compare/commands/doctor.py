"""The commands ``doctor`` (what this machine has and lacks) and ``completion`` (for the shell)."""

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
from rollbench.compare.running import available_GB, cores, gmsh_fault, gmsh_remedy
from rollbench.compare.text.printing import Answer, print_answer, writing

State = Literal["ok", "missing", "optional"]

#: Least version of Python.
PYTHON = (3, 11)

#: Licences that ask something of who passes the program on with what it imports.
STRICT = {"gmsh": "GPL-2.0-or-later, with exceptions for linking"}

LICENCES = (
    "The code of rollbench is under the MIT licence. It imports gmsh, which is under the GNU GPL: whoever distributes it "
    "together with gmsh must comply with the GPL. Only the 3D reference imports gmsh."
)

#: Memory [GB] for one run of the reference on level 1 of a screw of 32 balls, and free disc [GB] for its caches.
ENOUGH_GB, DISC_GB = 4.0, 2.0

#: Other programs: what they are for, and the Debian package.
PROGRAMS = {
    "ccx": (("ccx",), "crosscheck --run solves with CalculiX", "calculix-ccx"),
    "chromium": (("chromium", "chromium-browser", "google-chrome"), "tests open the report in a browser", "chromium"),
}


@dataclass(frozen=True)
class Check:
    """One check of the machine.

    state: "optional" if it is absent and not needed; found: what was found; cost: what its absence costs, and advice: the
    remedy, both empty where it is present.
    """

    name: str
    state: State
    found: str
    cost: str = ""
    advice: str = ""

    def line(self) -> str:
        """Return the check as one line."""
        return f"{self.state:8}  " + "; ".join(filter(None, (f"{self.name}: {self.found}", self.cost, self.advice)))


def run_doctor(store: Path) -> Answer:
    """Check the machine; exit code 1 if something is missing that is not optional."""
    checks = [*_python(), *_packages(), *_graphics(), *_programs(), *_folders(store), *_size(), *_shipped()]
    lacking = [check for check in checks if check.state == "missing"]
    rows = [asdict(check) for check in checks]
    data = {"rollbench": __version__, "complete": not lacking, "checks": rows, "licences": LICENCES}
    end = f"{len(lacking)} missing" if lacking else "nothing is missing"
    parts = [f"rollbench {__version__}", *(check.line() for check in checks), end, LICENCES]
    return Answer(data, parts, 1 if lacking else 0)


def _looked(name: str, found: str, lack: str, cost: str, advice: str, without: State = "missing") -> Check:
    """Return the check of a requirement: found, or missing with cost, remedy and state."""
    return Check(name, without, lack, cost, advice) if lack else Check(name, "ok", found)


def _python() -> Iterator[Check]:
    present, least = platform.python_version(), ".".join(map(str, PYTHON))
    old = tuple(map(int, platform.python_version_tuple()[:2])) < PYTHON
    lack = present if old else ""
    yield _looked("Python", f"{present}, at least {least}", lack, "not supported", f"install Python {least} or newer")


def requirements() -> dict[str, str]:
    """Return the least versions of the packages of rollbench and its extras, by name; empty if it is not installed."""
    from rollbench.meshes.libraries import EXTRA

    try:
        lines = metadata.requires("rollbench") or []
    except metadata.PackageNotFoundError:
        return {}
    bounds = (re.fullmatch(r"([\w.-]+)\s*>=\s*([\d.]+)(?:; extra == .(\w+).)?", line.strip()) for line in lines)
    return {bound[1]: bound[2] for bound in bounds if bound and (bound[3] is None or EXTRA.get(bound[1]) == bound[3])}


def _packages() -> Iterator[Check]:
    from rollbench.meshes.libraries import EXTRA, ONLY_FOR, fault, pip, version

    needed = requirements()
    if not needed:
        yield Check(
            "rollbench", "missing", "not installed", "versions of packages are not known", "pip install . installs it"
        )
    for name, least in needed.items():
        present, wanted, lack = version(name), f"'{name}>={least}'", ""
        state: State = "missing"
        advice, licence = f"pip install {wanted}", f" ({STRICT[name]})" if name in STRICT else ""
        if present is None:
            lack = "not installed"
            if name in EXTRA:
                advice, state = pip(name), "optional"
        elif _numbers(present) < _numbers(least):
            lack = f"{present}, older than {least}"
        elif name != "gmsh" and (broken := fault(name)):  # gmsh: see `_graphics`
            lack, advice = f"{present}, {broken}", f"pip install --force-reinstall {wanted}"
        cost = ONLY_FOR.get(name, "rollbench does not run")
        yield _looked(name, f"{present}, at least {least}{licence}", lack, cost, advice, state)


def _numbers(version: str) -> tuple[int, ...]:
    """Return the leading numbers of a version.

    Examples
    --------
    >>> _numbers("4.15.2rc1") > _numbers("4.13")
    True
    """
    return tuple(int(number) for number in re.findall(r"\d+", re.split(r"[^\d.]", version)[0]))


def _graphics() -> Iterator[Check]:
    from rollbench.meshes.libraries import ONLY_FOR, PICTURES, install, version
    from rollbench.reports import offscreen

    if version("gmsh"):
        yield _looked("meshing", "gmsh loads", gmsh_fault(), ONLY_FOR["gmsh"], gmsh_remedy())
    if version("pyvista"):
        lack, cost = offscreen.fault(), ONLY_FOR["pyvista"]
        yield _looked("off-screen rendering", "a picture was drawn", lack, cost, install(PICTURES))


def _programs() -> Iterator[Check]:
    for name, (commands, purpose, package) in PROGRAMS.items():
        path = next(filter(None, map(shutil.which, commands)), "")
        lack, advice = "" if path else "not found", f"apt-get install {package}"
        yield _looked(name, path, lack, f"needed only so that {purpose}", advice, "optional")


def _folders(store: Path) -> Iterator[Check]:
    from rollbench.lowfi.jit import code_folder, is_machine_code_cached
    from rollbench.meshes.cache import default_root

    folder, slow = code_folder(), "compiles for some 20 s"
    kept = f"kept in {folder and folder.parent}" + ("" if is_machine_code_cached() else f"; the first use {slow}")
    lack = "" if folder else "not kept"
    yield _looked("compiled kernels", kept, lack, f"every process {slow}", "see ROLLBENCH_CACHE")
    root = default_root()
    if root is None:
        yield Check("cache of meshes", "optional", "switched off", "meshes are built every time", "unset ROLLBENCH_CACHE")
    else:
        yield _folder("cache of meshes", root, "meshes are built every time", "name another with ROLLBENCH_CACHE")
    yield _folder("store of references", store, "no run of the 3D reference can be kept", "name another by --store")


def _folder(name: str, folder: Path, cost: str, advice: str) -> Check:
    from rollbench.compare.errors import InputError
    from rollbench.compare.files import need_writable

    near = folder
    while not near.exists() and near != near.parent:
        near = near.parent
    try:
        lack = "" if near.is_dir() else f"{near} is no folder"
        if not lack:
            need_writable(near / "rollbench-probe")
    except InputError as error:
        lack = f"{folder}: {error.value}"
    free = 0.0 if lack else 1e-9 * shutil.disk_usage(near).free
    if not lack and free < DISC_GB:
        lack, advice = f"{folder}: {free:.1f} GB free", f"free at least {DISC_GB:g} GB"
    return _looked(name, f"{folder} can be written to, {free:.0f} GB free", lack, cost, advice)


def _size() -> Iterator[Check]:
    yield Check("cores", "ok", f"{cores()} of {os.cpu_count()} for this process")
    free = available_GB()
    if free is None:
        yield Check("memory", "optional", "not known on this system", "3D runs start without checking it")
        return
    room = f"{free:.1f} GB free; a 3D run of 64 contacts takes up to {ENOUGH_GB:g} GB"
    lack = f"{free:.1f} GB free" if free < ENOUGH_GB else ""
    cost = f"less than a 3D run of 64 contacts needs ({ENOUGH_GB:g} GB)"
    yield _looked("memory", room, lack, cost, "close other programs, or take a larger machine")


def _shipped() -> Iterator[Check]:
    from rollbench.compare.reference.estimate import reference
    from rollbench.compare.reference.store import PROGRAMS
    from rollbench.compare.scenes import catalogue

    names = catalogue.with_role("referenced")
    held = [kept for name in names if (kept := reference(catalogue.scene(name))) is not None]
    programs = ", ".join(
        f"{program} {' and '.join(sorted({run.versions[program] for kept in held for run in kept.runs}))}"
        for program in PROGRAMS
    )
    lack = "" if len(held) == len(names) else f"of {len(held)} of {len(names)} scenes, made by {programs}"
    found, cost = f"of all {len(names)} scenes, made by {programs}", "the others are recomputed, in hours"
    yield _looked("shipped references", found, lack, cost, "reinstall rollbench")


@app.command
def doctor(*, store: Path = Path("rollbench-reference"), as_json: Json = False) -> int:
    """Check this machine: packages, system libraries, rendering, folders, memory, licences; what is missing and its effect.

    Exit codes: 0 nothing is missing (optional programs and packages of extras that are not installed do not count), 1
    something is.

    Parameters
    ----------
    store
        Folder of stored reference runs.
    """
    return print_answer(run_doctor(store), as_json)


@app.command
def completion(shell: Literal["bash", "zsh", "fish"], *, install: Flag = False) -> None:
    """Print the script with which a shell completes commands and options, or install it.

    Parameters
    ----------
    shell
        bash, zsh or fish.
    install
        Write the script to where the shell looks for it in the home folder, and print the path.
    """
    text = app.generate_completion(prog_name="rollbench", shell=shell)
    if install:
        print_answer(Answer(parts=[f"{app.install_completion(shell=shell)} written; open a new shell"]))
    else:
        with writing():
            sys.stdout.write(f"{text}\n")
