"""CalculiX on a deck: running it, and reading what it printed."""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.compare.errors import InputError

#: Name of the deck and of its results in their folder.
NAME = "deck"
LONGEST = 7200.0
#: Components along x, y, z.
Triple = tuple[float, ...]


@dataclass(frozen=True)
class Outcome:
    """Results of CalculiX: resultants [N] on the faces of contacts by slave set, displacements of the printed sets' nodes
    by set and node (deck's unit), iterations, last correction of the displacements over the largest [%], seconds of
    processor time, date, version."""

    forces: dict[str, Triple]
    moved: dict[str, dict[int, Triple]]
    iterations: int
    correction: float
    seconds: float
    date: str
    version: str


def find_ccx() -> str:
    """Path of CalculiX. Raises InputError where it is not installed."""
    found = shutil.which("ccx")
    if found is None:
        advice = "install it (Debian: apt-get install calculix-ccx), or leave `run` out"
        raise InputError("this machine", "ccx", "not found", "CalculiX on the path", advice)
    return found


def ccx_version(program: str) -> str:
    """Version that CalculiX gives of itself."""
    text = subprocess.run([program, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"[Vv]ersion\s+(\S+)", text)
    return found.group(1) if found else "unknown"


def digest(text: str) -> str:
    """Digest of a deck without its comments and solver controls, 16 hexadecimal digits."""
    content, control = [], False
    for line in text.splitlines():
        if line.startswith("*") and not line.startswith("**"):
            control = line.startswith("*CONTROLS")
        if not (control or line.startswith("**")):
            content.append(line)
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]


def run_calculix(text: str, folder: Path) -> Outcome:
    """Run a deck in a folder, one thread; a result of the same deck that is there already is read instead.

    Raises InputError where CalculiX is missing, and ValueError, with its last words, where it does not converge.
    """
    program, key = find_ccx(), digest(text)
    kept = folder / "run.json"
    try:
        facts = json.loads(kept.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        facts = {}
    if facts.get("deck") != key:
        facts = {"deck": key, **_run(program, text, folder)}
        kept.write_text(json.dumps(facts), encoding="utf-8")
    forces, moved = read_dat((folder / f"{NAME}.dat").read_text(encoding="ascii"))
    iterations, correction = read_cvg((folder / f"{NAME}.cvg").read_text(encoding="ascii"))
    return Outcome(forces, moved, iterations, correction, facts["seconds"], facts["date"], facts["version"])


def _run(program: str, text: str, folder: Path) -> dict[str, Any]:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{NAME}.inp").write_text(text, encoding="ascii")
    for old in folder.glob(f"{NAME}.[dcfs]*"):
        old.unlink()
    before = os.times()
    try:
        done = subprocess.run(
            [program, "-i", NAME], cwd=folder, capture_output=True, text=True, check=False, timeout=LONGEST
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"CalculiX took longer than {LONGEST:.0f} s") from None
    after = os.times()
    if done.returncode or "*ERROR" in done.stdout or "Job finished" not in done.stdout:
        faults = [line.strip() for line in done.stdout.splitlines() if "*ERROR" in line] or done.stdout.split("\n")[-3:]
        raise ValueError(f"CalculiX failed (code {done.returncode}): {' '.join(faults[:3])}")
    seconds = after.children_user + after.children_system - before.children_user - before.children_system
    today = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
    elapsed = after.elapsed - before.elapsed  # where children are not accounted for (Windows); of one thread, too
    return {"seconds": seconds or elapsed, "date": today, "version": ccx_version(program)}


def read_dat(text: str) -> tuple[dict[str, Triple], dict[str, dict[int, Triple]]]:
    """Contact forces by slave set, and printed displacements by set and node, of the last time in a .dat file."""
    forces: dict[str, Triple] = {}
    moved: dict[str, dict[int, Triple]] = {}
    head = re.compile(r"(?:statistics for slave set (\S+), master|displacements .* for set (\S+) and time).*")
    ends = [*(m.start() for m in head.finditer(text)), len(text)]
    for found, end in zip(head.finditer(text), ends[1:], strict=True):
        rows = [line.split() for line in text[found.end() : end].splitlines() if re.match(r"\s+[-\d]", line)]
        if found[1]:
            forces[found[1]] = tuple(map(float, rows[0][:3]))
        else:
            moved[found[2]] = {int(node): tuple(map(float, x)) for node, *x in rows}
    return forces, moved


def read_cvg(text: str) -> tuple[int, float]:
    """Iterations of all increments, and the last correction of the displacements over the largest [%]; a linear step,
    which prints none, has one iteration."""
    rows = [line.split() for line in text.splitlines() if re.match(r"\s+\d+\s+\d+\s+\d+\s+\d+", line)]
    return (len(rows), float(rows[-1][6])) if rows else (1, 0.0)
