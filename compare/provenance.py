"""Provenance of results: git commit and hash of rollbench's source code, and hashes of the inputs of a report."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path

from rollbench.compare import files as data
from rollbench.compare.case import case_files_named, shipped_toml_files
from rollbench.reports.manifest import sha256

#: Packages whose source code affects the pages of a report.
PACKAGES = ("compare", "hifi", "lowfi", "meshes", "reports")
#: Patterns of the file names in a folder of stored runs of the 3D reference.
STORED = ("*.json", "*.npz", "*.toml")
#: Name of the source code in a manifest, which is the list of a report's inputs with their hashes.
SOURCES = "sources of rollbench"
#: First word of the names of scenes, of printed data and of stored runs of the 3D reference in a report's manifest.
SCENE, DATA, RUN = "scene ", "printed ", "reference "


@cache
def source_commit() -> str:
    """Return the git commit of the program's source code, or the reason why it is not known.

    ", changed since" is added if files differ from the commit. The result is that of the first call, so files that a report
    writes into the repository later do not count as changes.
    """
    root = Path(__file__).resolve().parents[1]
    if not (root / ".git").exists():
        return "not a repository: an installed package"
    try:
        run = [
            subprocess.run(["git", "-C", str(root), *args], capture_output=True, text=True, check=True, timeout=20).stdout
            for args in (("rev-parse", "HEAD"), ("status", "-s", "-uno"))
        ]
    except (OSError, subprocess.SubprocessError):
        return "not known: git does not answer"
    return run[0].strip() + (", changed since" if run[1].strip() else "")


def _source_folder(package: str) -> Path:
    """Return the path of a folder with source code in the installed package; ``package``: such as ``compare/studies``."""
    first, *rest = package.split("/")
    return Path(str(resources.files("rollbench").joinpath(first, *rest)))


def sources_hash(folders: Sequence[str] = PACKAGES, text: str = "") -> str:
    """Return a SHA-256 hash of the names and contents of all Python files in folders of rollbench, and of a text.

    ``folders``: names of the folders, such as "compare"; ``text``: the text; empty: none.
    """
    lines = [text] if text else []
    for package in folders:
        root = _source_folder(package)
        files = sorted(p for p in root.rglob("*.py") if "__pycache__" not in p.parts)
        lines += [f"{package}/{p.relative_to(root).as_posix()} {sha256(p.read_bytes())}" for p in files]
    return sha256("\n".join(lines))


def files_of_printed_values() -> dict[str, Path]:
    """Return the files with printed numbers, misprints and uncompared values of publications, by name in manifests."""
    files = {f"{name}.toml": path for name, path in shipped_toml_files("printed").items()}
    files |= {f"misprints/{case.name}.toml": path for case, path in case_files_named("misprints.toml").items()}
    return files | {"left-out.toml": data.shipped_path("cases/left-out.toml")}


def hashes_of_report_inputs(stores: Sequence[Path], scenes: Mapping[str, str]) -> dict[str, str]:
    """Return the SHA-256 hashes of all inputs of a report, by the names that its manifest uses.

    The inputs are the source code, the scenes (texts by name), the printed data, and the stored runs of the 3D reference.
    ``stores``: folders with runs; if a file exists in several of them, the first one is used; ``scenes``: text of each
    scene file by the name of the scene.
    """
    hashes = {SOURCES: sources_hash()}
    hashes |= {f"{SCENE}{name}": sha256(text) for name, text in sorted(scenes.items())}
    for name, path in sorted(files_of_printed_values().items()):
        hashes[f"{DATA}{name}"] = sha256(path.read_bytes())
    for store in reversed(stores):
        for path in sorted(p for pattern in STORED for p in store.glob(pattern)):
            hashes[f"{RUN}{path.name}"] = sha256(path.read_bytes())
    return hashes
