"""What the machine must have for the 3D reference, checked before anything is computed."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from rollbench.compare.errors import InputError
from rollbench.meshes.libraries import MESHING, REFERENCE, fault, install, missing, pip, version


def gmsh_fault() -> str:
    """Why gmsh cannot be loaded, with the shared libraries that are missing; empty where it can."""
    reason = fault("gmsh")
    if not reason or version("gmsh") is None:
        return reason
    lacking = [name for name in missing(MESHING) if name not in reason]
    return reason + (f"; also missing: {', '.join(lacking)}" if lacking else "")


def gmsh_remedy() -> str:
    """What to do where gmsh cannot be loaded."""
    return pip("gmsh") if version("gmsh") is None else install(MESHING)


def need_gmsh() -> None:
    """Raise InputError where gmsh cannot be loaded."""
    reason = gmsh_fault()
    if reason:
        advice = f"{gmsh_remedy()}, or leave the 3D reference out; see rollbench doctor"
        raise InputError("this machine", "gmsh", reason, "gmsh with its shared libraries", advice)


def need_packages(*packages: str) -> None:
    """Raise InputError for the first of some Python packages that cannot be used."""
    for package in packages:
        if reason := fault(package):
            advice = f"{pip(package)}; see rollbench doctor for what works without"
            raise InputError("this machine", package, reason, "a package that this command needs", advice)


def need_reference() -> None:
    """Raise InputError where no run of the 3D reference can be computed."""
    need_gmsh()
    need_packages(*REFERENCE)


def libraries(packages: Sequence[str]) -> str:
    """Packages with their versions, in words."""
    return ", ".join(f"{name} {version(name) or 'not installed'}" for name in packages)


def machine() -> str:
    """Processor and number of cores, in words."""
    cpu = platform.processor() or platform.machine()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        cpu = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), cpu)
    return f"{cpu}, {os.cpu_count()} cores"


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def out_of_memory(reason: object) -> InputError:
    """The error of work that needs more memory than this machine has."""
    advice = "end other programs, take a coarser level or fewer workers, or a cluster (`backend=dask`)"
    return InputError("this machine", "memory", str(reason) or "used up", "enough for the run", advice)


def available_GB(proc: Path = Path("/proc/meminfo"), group: Path = Path("/sys/fs/cgroup")) -> float | None:
    """Memory that a process can take without swapping [GB], at most what its control group leaves; None where the system
    does not say."""
    limits = []
    with suppress(OSError, ValueError, StopIteration):
        lines = proc.read_text(encoding="ascii").splitlines()
        limits.append(1.024e-6 * float(next(line.split()[1] for line in lines if line.startswith("MemAvailable"))))
    with suppress(OSError, ValueError):  # "max": no limit
        limit, used = ((group / name).read_text(encoding="ascii") for name in ("memory.max", "memory.current"))
        limits.append(max(1e-9 * (float(limit) - float(used)), 0.0))
    return min(limits, default=None)
