"""What the command line of ``rollbench solve`` says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Choices:
    """What the command line says: model, whether to leave nothing out, specimen, condensed bodies, whether to print the
    table of balls, station of the stiffness and its file, files of the load curve and of the contact loads, seconds after
    which to give up, whether a warning above the answers makes the exit code 1, whether to print what lies behind them."""

    model: str = ""
    everything: bool = False
    member: int = 0
    condensed: Path | None = None
    balls: bool = False
    stiffness_at: str = ""
    matrix: Path | None = None
    curve: Path | None = None
    loads_csv: Path | None = None
    time_limit: float | None = None
    strict: bool = False
    assumptions: bool = False
