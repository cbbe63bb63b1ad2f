"""Summaries of sweeps that are shipped: each the ``summary.json`` of a command that its file names."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

#: The study of tolerances of case 3.
TOLERANCES = "tolerances-case3"


@cache
def stored(name: str) -> dict[str, Any]:
    """The shipped summary of that name."""
    text = Path(__file__).with_name(f"{name}.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def command(found: Mapping[str, Any]) -> str:
    """The command that a summary comes from."""
    vary = " ".join(f'--vary "{text}"' for text in found["vary"])
    scene = found["scene"].removesuffix(".toml")
    return (
        f"rollbench sweep {scene} {vary} --samples {found['samples']} --method {found['method']} --seed {found['seed']} "
        f"--model {found['model']}"
    )
