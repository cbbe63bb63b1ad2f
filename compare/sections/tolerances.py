"""Report section on how ball grade, pitch error, roundness and misalignment affect the largest load in Lin's case 3."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from rollbench.compare import files
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.studies.columns import MAIN
from rollbench.compare.studies.sweep.keys import VariedKey, read_varied_keys
from rollbench.compare.studies.sweep.run import GroupMean, SobolIndex, SobolIndices, sweep_figures
from rollbench.reports.content import Row, Section, Table, Text

#: Shipped summary of the tolerance sweep (``summary.json``); it states the command that computed it.
TOLERANCES = "studies/sweep/tolerances-case3.json"
#: Descriptions of the varied tolerances, by the beginning of their keys in the scene file.
WORDS = {
    "errors.balls.sigma": "ball grade: standard deviation of the ball radius",
    "errors.SL.pitch": "pitch error: standard deviation of its amplitude, once per turn, all flanks",
    "errors.SL.roundness": "roundness: standard deviation of its amplitude, twice per turn, all flanks",
    "supports[1].displace.ux": "misalignment: offset of the right end",
    "errors.seed": "chance: seed of the random errors within the same tolerances",
}


@cache
def stored_tolerance_sweep() -> dict[str, Any]:
    """Return the shipped summary of the tolerance sweep of Lin's case 3: results, main effects and Sobol indices."""
    found: dict[str, Any] = json.loads(files.shipped_text(TOLERANCES))
    outputs = {
        name: None if of is None else {key: SobolIndex(**index) for key, index in of.items()}
        for name, of in found["indices"]["outputs"].items()
    }
    effects = {key: [GroupMean(**group) for group in groups] for key, groups in found["main_effects"].items()}
    return found | {"main_effects": effects, "indices": SobolIndices(**(found["indices"] | {"outputs": outputs}))}


def tolerance_description(tolerance: VariedKey) -> str:
    """Return the description of a varied tolerance, such as "misalignment: offset of the right end"."""
    return next((text for start, text in WORDS.items() if tolerance.key.startswith(start)), tolerance.short_name)


def tolerance_effect_rows(tolerances: Sequence[VariedKey], sweep_summary: Mapping[str, Any]) -> Iterator[Row]:
    """Yield table rows on the effect of each tolerance on the largest contact load, the most influential tolerance first.

    ``tolerances``: varied tolerances with their ranges. ``sweep_summary``: summary of the sweep. Each row has the range
    of the tolerance, and the first-order and total Sobol index with confidence intervals. The range is divided into parts,
    and the largest contact load [N] is averaged over the samples in each; the smallest and the largest of these averages
    are also in the row.
    """
    indices, confidence = sweep_summary["indices"].outputs[MAIN], f"{100 * sweep_summary['indices'].confidence:g}"
    for vary in sorted(tolerances, key=lambda v: -indices[v.key].total):
        means = [g.mean for g in sweep_summary["main_effects"][vary.key]]
        index = indices[vary.key]
        yield {
            "tolerance": tolerance_description(vary),
            "tolerance_range": "any" if vary.key == "errors.seed" else f"{vary.low:g} to {vary.high:g} {vary.unit}",
            "lowest_mean": min(means),
            "highest_mean": max(means),
            "sobol_first": index.first,
            ("sobol_first_band", confidence): f"{index.first_low:.2f} to {index.first_high:.2f}",
            "sobol_total": index.total,
            ("sobol_total_band", confidence): f"{index.total_low:.2f} to {index.total_high:.2f}",
        }


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on the effect of each tolerance on the largest contact load in case 3 of Lin's thesis.

    ``cache``: collects the scenes that the report uses. ``step`` is called with each line of progress.
    """
    step("stored sweep of tolerances")
    found = stored_tolerance_sweep()
    cache.record_used_scenes((found["scene"].removesuffix(".toml"),))
    keys = read_varied_keys(found["vary"])
    rows = list(tolerance_effect_rows(keys, found))
    load = found["outputs"][MAIN]
    luck = next(row for row in rows if row["tolerance_range"] == "any")
    first, second = [row for row in rows if row is not luck][:2]
    largest, then = (str(row["tolerance"]).partition(":")[0].capitalize() for row in (first, second))
    conclusion = (
        f"On {found['converged']} screws with random errors within tolerances, the largest contact load is "
        f"{load['mean']:.0f} N on average and exceeds {load['quantile_0.95']:.0f} N on one screw in twenty. "
        f"{largest} has the largest effect (total Sobol index {first['sobol_total']:.2f}), "
        f"then {then.lower()} ({second['sobol_total']:.2f}); chance, the random errors "
        f"within the same tolerances, has an index of {luck['sobol_total']:.2f}."
    )
    vary = "".join(f' --vary "{text}"' for text in found["vary"])
    options = "".join(f" --{name} {found[name]}" for name in ("samples", "method", "seed", "model"))
    text = (
        (
            "The ranges of the tolerances are assumed, each from zero to a usual value; Lin's thesis states no tolerances. "
            "The Sobol indices are shares of the variance over these ranges: the first-order index for the tolerance "
            "alone, the total index including its interaction with others. Their "
            f"{100 * found['indices'].confidence:g} % intervals follow from resampling the design."
        ),
        f"Computed by: rollbench sweep {found['scene'].removesuffix('.toml')}{vary}{options}.",
    )
    table = Table.from_rows("tolerances", "Effect of each tolerance on the largest contact load", rows)
    named = [replace(key, shown_name=tolerance_description(key).partition(":")[0]) for key in keys]
    figures = sweep_figures("tolerances", named, found["main_effects"], found["worst"], found["indices"])
    title = "Effect of each tolerance on the largest contact load in Lin's case 3"
    return Section("tolerances", title, (Text(text), table, *figures), conclusion=conclusion)
