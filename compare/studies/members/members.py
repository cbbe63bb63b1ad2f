"""Ensemble of specimens of a scene with random errors, by any model (``rollbench solve SCENE --members N``).

A specimen is the scene with one random draw of its geometric errors.

Results are statistics of outputs and distributions of the contact loads, with their sampling errors. Specimens are solved
in blocks that may run in parallel. A specimen depends only on the scene's seed and its number, and blocks are combined in
order, so that the results do not depend on the number of processes. Memory holds a block of loads in each process, six
numbers per specimen, and one histogram per contact.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.files import replaced_file
from rollbench.compare.models.many import StoredIn, in_order, solve_many, stored_in
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import default_model_name, has_random_errors, model_by_name, run_model
from rollbench.compare.quantities import json_number
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.results.data import Ensemble, Statistics, output_statistics
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.scenes.scene_file import scenes_to_solve
from rollbench.compare.studies.members import ensemble
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene

#: Largest and smallest number of specimens of a block.
BLOCK, LEAST = 500, 50

#: Number of bins of the histogram of a contact load, and upper end of the histogram over the largest contact load of the
#: scene without random errors.
BINS, END = 2000, 10.0

#: Largest number of specimens.
MOST = 10_000_000


class LoadDistributions:
    """Distribution of each contact load over many random draws of the geometric errors, from sums and histograms.

    N is the number of balls; the four contacts of a ball are those on the flanks SL, SR, NL, NR (screw left and right, nut
    left and right).

    Parameters
    ----------
    nominal
        Contact loads of the scene solved without random errors, (N, 4) [N].
    width
        Width of a bin of the histograms [N]; the first bin is for zero loads, the last for loads above the upper end of the
        histogram.
    """

    def __init__(self, nominal: Array, width: float) -> None:
        """Start with empty sums and histograms; the class describes the parameters."""
        self.nominal, self.width = nominal, width
        self._first, self._second = np.zeros(nominal.shape), np.zeros(nominal.shape)
        self._low, self.largest = np.full(nominal.shape, np.inf), np.zeros(nominal.shape)
        self.counts = np.zeros((*nominal.shape, BINS + 2), dtype=np.int64)

    def add_loads(self, loads: Array) -> None:
        """Add the contact loads of k random draws to sums and histograms; draws without equilibrium are left out.

        ``loads``: contact loads (k, N, 4) [N] of N balls, nan without equilibrium. They are added one after the other in
        order, so that the sums do not depend on the division into blocks.
        """
        counts, place = self.counts.reshape(-1, BINS + 2), np.arange(self.nominal.size)
        for load in loads[~np.isnan(loads[:, 0, 0])]:
            off = load - self.nominal
            self._first += off
            self._second += off * off
            np.minimum(self._low, load, out=self._low)
            np.maximum(self.largest, load, out=self.largest)
            bins = np.where(load > 0.0, 1 + np.minimum(load / self.width, BINS), 0).astype(np.int64)
            counts[place, bins.ravel()] += 1

    @property
    def _draw_count(self) -> int:
        """Number of random draws whose contact loads were added."""
        return int(self.counts.reshape(-1, BINS + 2)[0].sum())

    @property
    def mean_loads(self) -> Array:
        """Mean load of each contact over the random draws, (N, 4) [N], for N balls and the four groove flanks."""
        return self.nominal + self._first / max(self._draw_count, 1)

    @property
    def standard_deviation(self) -> Array:
        """Standard deviation of each contact load over the random draws, (N, 4) [N], for N balls and four flanks."""
        n = self._draw_count
        mean = self._first / max(n, 1)
        return np.asarray(np.sqrt(np.maximum(self._second - n * mean**2, 0.0) / max(n - 1, 1)))

    @property
    def smallest_loads(self) -> Array:
        """Smallest load of each contact in all random draws, (N, 4) [N], for N balls and the four groove flanks."""
        return np.where(np.isfinite(self._low), self._low, 0.0)

    @property
    def loaded_share(self) -> Array:
        """Fraction of the random draws in which each contact carries load, (N, 4), for N balls and four flanks."""
        return 1.0 - self.counts[..., 0] / max(self._draw_count, 1)

    def load_quantiles(self, level: float) -> Array:
        """Return a quantile of each contact load over the random draws, (N, 4) [N], accurate to the bin width.

        ``level``: level of the quantile, from 0 to 1. N is the number of balls.
        """
        below = np.cumsum(self.counts, axis=-1)
        place = (below < level * below[..., -1:]).sum(axis=-1)
        return np.asarray(np.where(place == 0, 0.0, (place - 0.5) * self.width))


@dataclass(frozen=True)
class EnsembleSummary:
    """Results of M random draws of the geometric errors of a scene (specimens), by one model."""

    #: Scene with the random errors.
    scene: Scene | Assembly
    #: Name of the model.
    model: str
    #: Outputs of each specimen in the order of `ensemble.output_names_of_draw`, (M, k); nan without equilibrium.
    outputs: Array
    #: Status of each specimen without equilibrium, by the number of the specimen.
    status_of_failed_draws: dict[int, str]
    #: Distributions of the contact loads over the specimens; the balls of a shaft come one nut or bearing after the other.
    load_distributions: LoadDistributions
    #: Wall-clock time of all blocks [s], also of those that an earlier run has stored.
    seconds: float


def solve_random_draws_of_scene(
    scene: Scene | Assembly,
    model: str,
    count: int,
    engine: ComputingSettings | None = None,
    show_progress: Callable[[str], None] = lambda _: None,
    record_specimen: Callable[[int, str, Array], None] = lambda *_: None,
    stored: StoredIn | None = None,
    first_row: int = 0,
) -> EnsembleSummary:
    """Solve a scene for the first ``count`` random draws of its geometric errors (specimens).

    Parameters
    ----------
    scene
        Scene of one nut or bearing, or of a shaft with several.
    model
        Name of the model.
    count
        Number of specimens.
    engine
        Number of processes, or cluster, that solve blocks of specimens.
    show_progress
        Function that is called with each line of progress.
    record_specimen
        Function that is called with number, status and outputs (k,) of each specimen, in order of the numbers.
    stored
        Folder in which solved blocks are looked up and stored; None: none.
    first_row
        Number of the first block's row in that folder, which may hold the blocks of several scenes.

    Returns
    -------
    EnsembleSummary
        Outputs and distributions of the contact loads.

    Raises
    ------
    InputError
        If the model is unknown, the number out of range, or the scene has no random errors or no equilibrium without them.
    """
    model = model or default_model_name(scene)
    _check_ensemble_request(scene, model, count)
    bare = run_model(ensemble.without_random_errors(scene), model, ModelOptions(estimate_beam_mesh_error=False))
    nominal = ensemble.contact_loads_of_all_balls(bare)
    if not bare.converged or not nominal.max(initial=0.0) > 0.0:
        reason = "no contact carries load without the random errors"
        if not bare.converged:
            reason = f"{bare.status} (solved without its random errors)"
        advice = f"load or preload the {'screw' if isinstance(scene, Scene) else 'nuts or bearings'}"
        allowed = "a scene that converges with loaded contacts when it is solved without its random errors"
        raise InputError(scene.name, "scene", reason, allowed, advice)
    bands, rows, failed = LoadDistributions(nominal, END * float(nominal.max()) / BINS), list[Array](), dict[int, str]()
    least = LEAST if isinstance(scene, Scene) else 1
    size = max(least, min(BLOCK, count // 16))  # depends on the count only, as the division into blocks affects round-off
    blocks = {first_row + k: (scene, model, nominal, k, min(size, count - k)) for k in range(0, count, size)}
    solve, noun = ensemble.solve_block_of_random_draws, "blocks of members"
    done, seconds = 0, 0.0
    for row, block in in_order(solve_many(solve, blocks, engine, show_progress, noun=noun, stored=stored), [*blocks]):
        first = row - first_row
        bands.add_loads(block.loads)
        rows.append(block.outputs)
        for k, status in enumerate(block.statuses):
            record_specimen(first + k, status, block.outputs[k])
            if status != "converged":
                failed[first + k] = status
        done, seconds = done + len(block.outputs), seconds + block.seconds
        show_progress(f"[{done}/{count}] {len(failed)} failed")
    return EnsembleSummary(scene, model, np.concatenate(rows), failed, bands, seconds)


def _check_ensemble_request(scene: Scene | Assembly, model: str, count: int) -> None:
    """Check a request to solve many random draws of a scene's errors, before anything is solved.

    Raises InputError for an unknown model, a number of specimens out of range, or a scene without random errors.
    """
    single = isinstance(scene, Scene)
    if single:
        model_by_name(model, excluded_names=("condensed",))
    if not 2 <= count <= MOST:
        allowed = f"2 to {MOST} random draws of the geometric errors"
        advice = "take a thousand: they give the quantiles of the contact loads to within some per cent"
        raise ArgumentError("members", str(count), allowed, advice)
    if not has_random_errors(scene):
        where, table = ("errors", "[errors.balls]") if single else ("sets[].errors", "[sets.errors.balls]")
        advice = f'give a sigma to balls, pitch, roundness or profile, e.g. sigma = "0.04 um" under {table}'
        raise InputError(scene.name, where, "no random error", "at least one standard deviation (sigma) above zero", advice)


def solve_random_draws_of_load_cases(
    described: Described,
    name: str,
    model: str,
    count: int,
    seed: int | None,
    engine: ComputingSettings,
    show_progress: Callable[[str], None],
    csv_out: Path | None = None,
    store: str | Path | None = None,
) -> Ensemble:
    """Solve each load case of a scene for many random draws of its geometric errors (specimens).

    ``name``: file or name of the scene in error messages; ``count``: number of specimens; ``seed``: seed of the random
    errors, None for that of the scene; ``show_progress``: function that is called with each line of progress; ``csv_out``:
    file for the outputs of each specimen, or None; ``store``: folder in which solved blocks are looked up and stored, or
    None. Returns the statistics, with those of each load case if there are several.
    Raises InputError for inputs that `solve_random_draws_of_scene` refuses.
    """
    if seed is not None and not 0 <= seed < 2**62:
        raise ArgumentError("seed", str(seed), f"0 to {2**62 - 1}", "leave `seed` out for the seed of the scene")
    cases = [case.name for case in described.cases] if isinstance(described, DutyCycle) else []
    scenes = [
        scene if seed is None else ensemble.with_error_seed(scene, seed) for scene in scenes_to_solve(described, name)
    ]
    stored, each = stored_in(store, "members", model, scenes, count), list[Ensemble]()
    headings = [*(["case"] if cases else []), "member", "status", *ensemble.output_names_of_draw(scenes[0])]
    with _csv_row_writer(csv_out, headings) as write:
        for scene, head in zip(scenes, [[case] for case in cases] or [[]], strict=True):

            def write_row(number: int, status: str, outputs: Array, head: Sequence[str] = head) -> None:
                """Write the CSV row of one specimen; ``outputs``: its outputs, of which nan becomes an empty cell."""
                write([*head, number, status, *("" if np.isnan(v) else repr(float(v)) for v in outputs)])

            row = len(each) * count
            found = solve_random_draws_of_scene(scene, model, count, engine, show_progress, write_row, stored, row)
            each.append(_ensemble_of_summary(found))
    if not cases:
        return each[0]
    return Ensemble(
        scene=described.name,
        members=min(one.members for one in each),
        converged=min(one.converged for one in each),
        cases=dict(zip(cases, each, strict=True)),
    )


@contextmanager
def _csv_row_writer(path: Path | None, names: Sequence[str]) -> Iterator[Callable[[list[Any]], None]]:
    """Open a CSV file with the columns ``names``, and yield a function that writes a row to it.

    ``path``: the file; None: the function does nothing. The file appears under its name only when it is complete. Raises
    InputError if it cannot be written.
    """
    if path is None:
        yield lambda *_: None
        return
    with replaced_file(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        yield writer.writerow


def _ensemble_of_summary(summary: EnsembleSummary) -> Ensemble:
    """Return the statistics of many random draws: of the outputs, and of the contact loads, with the failures.

    For a shaft, rows of contacts begin with the number of the nut or bearing.
    """
    scene, kept, names = summary.scene, summary.outputs, ensemble.KEPT
    sets: dict[str, dict[str, Statistics | None]] = {}
    if isinstance(scene, Scene):
        seed: Any = scene.errors.seed
    else:
        names, seed = ensemble.WHOLE, [s.parts.errors.seed if isinstance(s.parts, Scene) else None for s in scene.sets]
        by_set = np.split(kept[:, len(names) :], len(scene.sets), axis=1)
        sets = {s.name: _statistics_of_columns(ensemble.OF_SET, of) for s, of in zip(scene.sets, by_set, strict=True)}
    return Ensemble(
        scene=scene.name,
        model=summary.model,
        seed=seed,
        seconds=summary.seconds,
        members=len(kept),
        converged=len(kept) - len(summary.status_of_failed_draws),
        outputs=_statistics_of_columns(names, kept),
        failed=summary.status_of_failed_draws,
        sets=sets,
        contacts=tuple(_contact_load_rows(scene, summary.load_distributions)),
        band_resolution=json_number(summary.load_distributions.width),
    )


def _statistics_of_columns(names: Iterable[str], outputs: Array) -> dict[str, Statistics | None]:
    """Return the statistics of outputs by their names; ``outputs``: a column for each name, (M, at least k)."""
    return {name: output_statistics(np.sort(outputs[:, k]), intervals=True) for k, name in enumerate(names)}


def _contact_load_rows(scene: Scene | Assembly, loads: LoadDistributions) -> Iterator[dict[str, Any]]:
    """Yield a JSON row for each contact that carries load in a specimen, with mean and quantiles of its load [N].

    ``loads``: distributions of the contact loads over many random draws of the geometric errors.
    """
    found = {
        "without_random_errors_N": loads.nominal,
        "mean_N": loads.mean_loads,
        "standard_deviation_N": loads.standard_deviation,
        "smallest_N": loads.smallest_loads,
        **{f"quantile_{level:g}_N": loads.load_quantiles(level) for level in (0.05, 0.5, 0.95)},
        "largest_N": loads.largest,
        "loaded_share": loads.loaded_share,
    }
    for number, place in enumerate(ensemble.ball_slices(scene), 1):
        of_set = {"set": number} if isinstance(scene, Assembly) else {}
        for i, s in np.argwhere(loads.largest[place] > 0.0) if place is not None else ():
            values = {key: json_number(x[place][i, s]) for key, x in found.items()}
            yield of_set | {"index": int(i) + 1, "side": SIDES[s]} | values
