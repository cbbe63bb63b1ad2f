"""The command ``rollbench stability``."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from compare.errors import InputError
from compare.extremes.rows import tally, wide_rows
from compare.extremes.static import FORMULATIONS, failures, table


def run_stability(*, as_json: bool, show: Callable[..., None], print_json: Callable[[Any], None]) -> int:
    """Run the table; print it; 1 where our solver fails on any case, else 0."""

    def progress(done: int, total: int, case: str) -> None:
        if sys.stderr.isatty() or not as_json:
            line = f"[{done}/{total}] {case}"
            sys.stderr.write(f"\r\033[K{line}" if sys.stderr.isatty() else f"{line}\n")

    rows = table(progress)
    if sys.stderr.isatty():
        sys.stderr.write("\r\033[K")
    bad = failures(rows)
    if as_json:
        print_json({"failures": len(bad), "rows": [asdict(r) for r in rows]})
        return 1 if bad else 0
    from rich.table import Table as Terminal

    out = Terminal(title="stability: cases by formulations", title_justify="left")
    for heading in ("case", *FORMULATIONS, "residual"):
        out.add_column(heading, justify="right" if heading == "residual" else "left")
    for line in wide_rows(rows):
        residual = line["residual"]
        out.add_row(
            str(line["case"]), *(str(line[f]) for f in FORMULATIONS), "–" if residual is None else f"{residual:.1e}"
        )
    show(out)
    for name, (solved, tried, total) in tally(rows).items():
        show(f"{name}: {solved} of {tried} tried ({total} cases)")
    for row in bad:
        show(f"FAILED: {row.case}: {row.status}; expected: {row.expected}")
    return 1 if bad else 0


def run_campaign(
    count: int,
    seed: int,
    model: str,
    files: int,
    kills: int,
    keep: Path | None,
    *,
    as_json: bool,
    show: Callable[..., None],
    print_json: Callable[[Any], None],
) -> int:
    """Run a campaign, print its counts and every bad outcome; 1 where there is any, else 0. With ``keep``, an interrupted
    one goes on from the lines beside that file.

    Raises InputError for counts and seeds out of range, an unknown model, and a file that cannot be written.
    """
    from compare.extremes.campaign import record
    from compare.extremes.campaign.part import Part
    from compare.models.registry import MODELS
    from compare.writing import need_writable, replace_file

    whole = (("--random", count, 1, 1_000_000), ("--seed", seed, 0, 2**31), ("--files", files, 0, 100_000))
    for name, value, low, high in (*whole, ("--kills", kills, 0, 10_000)):
        if not low <= value <= high:
            raise InputError("command line", name, str(value), f"{low} to {high}", "choose a number in that range")
    if model not in MODELS or model == "condensed":
        names = ", ".join(name for name in MODELS if name != "condensed")
        raise InputError("command line", "--model", model, names, "see: rollbench list")
    if keep is not None:
        need_writable(keep)

    def progress(done: int, total: int, text: str) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\033[K[{done}/{total}] {text}")

    part = None if keep is None else Part(keep.with_name(f"{keep.name}.{model}-{seed}.part"), seed, model)
    if part is not None and part.outcomes:
        sys.stderr.write(f"{len(part.outcomes)} scenes of an interrupted campaign are known\n")
    found = record.run_campaign(seed, count, model, files, kills, progress, part)
    if sys.stderr.isatty():
        sys.stderr.write("\r\033[K")
    if keep is not None:
        replace_file(keep, record.text(found, keep))
    if part is not None:
        part.path.unlink(missing_ok=True)
    if as_json:
        print_json(found)
    else:
        for line in record.lines(found):
            show(line)
    return 1 if found["bad"] else 0
