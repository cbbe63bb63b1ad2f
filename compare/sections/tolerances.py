"""Section on tolerances of case 3: effect of ball grade, pitch, roundness and misalignment on the largest load."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from rollbench.compare import files
from rollbench.compare.models.study import Study
from rollbench.compare.studies.sweep.keys import Vary, read_vary
from rollbench.compare.studies.sweep.sample import MAIN
from rollbench.compare.studies.sweep.summary import summary_figures
from rollbench.reports.content import Cell, Quantity, Section, Table, Text

#: The shipped summary: the ``summary.json`` of the command that it names.
TOLERANCES = "studies/sweep/tolerances-case3.json"
#: Names of the keys, by the beginning of their path.
WORDS = {
    "errors.balls.sigma": "ball grade: standard deviation of the ball radius",
    "errors.SL.pitch": "pitch: standard deviation of its amplitudes, once a turn, all flanks",
    "errors.SL.roundness": "roundness: standard deviation of its amplitudes, twice a turn, all flanks",
    "supports[1].displace.ux": "misalignment: offset of the right end",
    "errors.seed": "luck: which screw of these tolerances",
}


@cache
def stored() -> dict[str, Any]:
    """Return the shipped summary of the tolerance sweep."""
    found: dict[str, Any] = json.loads(files.text(TOLERANCES))
    return found


def command(found: Mapping[str, Any]) -> str:
    """Return the ``rollbench sweep`` command that made a summary."""
    vary = "".join(f' --vary "{text}"' for text in found["vary"])
    options = "".join(f" --{name} {found[name]}" for name in ("samples", "method", "seed", "model"))
    return f"rollbench sweep {found['scene'].removesuffix('.toml')}{vary}{options}"


def short(vary: Vary) -> str:
    """Return the short name of a varied key."""
    return key_description(vary).partition(":")[0]


def key_description(vary: Vary) -> str:
    """Return the description of a varied key."""
    return next((text for start, text in WORDS.items() if vary.key.startswith(start)), vary.name)


def _short(row: Mapping[str, Cell]) -> str:
    return str(row["key"]).partition(":")[0].capitalize()


def effects(keys: Sequence[Vary], found: Mapping[str, Any]) -> list[dict[str, Cell]]:
    """Return a row for each varied key, largest total Sobol index first: range of the mean largest load, indices."""
    indices = found["indices"]["outputs"][MAIN]
    rows: list[dict[str, Cell]] = []
    for vary in sorted(keys, key=lambda v: -indices[v.key]["total"]):
        means = [g["mean"] for g in found["main_effects"][vary.key]]
        row = indices[vary.key]
        rows.append(
            {
                "key": key_description(vary),
                "range": "any" if vary.key == "errors.seed" else f"{vary.low:g} to {vary.high:g} {vary.unit}",
                "low": min(means),
                "high": max(means),
                **{name: row[name] for name in ("first", "total")},
                **{f"{name}_band": f"{row[f'{name}_low']:.2f} to {row[f'{name}_high']:.2f}" for name in ("first", "total")},
            }
        )
    return rows


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("stored sweep of tolerances")
    found = stored()
    study.uses((found["scene"].removesuffix(".toml"),))
    keys = read_vary(found["vary"])
    rows = effects(keys, found)
    load = found["outputs"][MAIN]
    luck = next(row for row in rows if row["range"] == "any")
    first, second = [row for row in rows if row is not luck][:2]
    conclusion = (
        f"Over {found['converged']} screws within tolerances the largest contact load is {load['mean']:.0f} "
        f"N on average and exceeds {load['quantile_0.95']:.0f} N on one screw in twenty. {_short(first)} "
        f"matters most (total index {first['total']:.2f}), then {_short(second).lower()} "
        f"({second['total']:.2f}); chance, that is which screw with the same tolerances is drawn, has "
        f"{luck['total']:.2f}."
    )
    text = (
        (
            "The ranges are assumed, each from zero to a common value; the source has no tolerances. The "
            "indices are shares of the variance over these ranges: first, of the tolerance alone; total, "
            f"including its interaction with others. Their {100 * found['indices']['confidence']:g} % intervals "
            "come from resampling the design."
        ),
        f"Computed by: {command(found)}.",
    )
    columns = (
        Quantity("key", "key", "", "s"),
        Quantity("range", "range", "", "s"),
        Quantity("low", "smallest mean of the largest load", "N", "g4"),
        Quantity("high", "largest mean", "N", "g4"),
        Quantity("first", "first index", "", ".2f"),
        Quantity("first_band", "interval of the first", "", "s"),
        Quantity("total", "total index", "", ".2f"),
        Quantity("total_band", "interval of the total", "", "s"),
    )
    table = Table("tolerances", "Effect of each tolerance on the largest contact load", columns, rows)
    figures = summary_figures("tolerances", keys, found, short)
    return Section(
        "tolerances", "Tolerances of case 3: which matters most", (Text(text), table, *figures), conclusion=conclusion
    )
