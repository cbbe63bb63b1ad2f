"""Run of a sweep: missing samples are solved in batches, in parallel if requested, and every sample is stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError, ProgramError, Refusal
from rollbench.compare.models import user_models
from rollbench.compare.models.registry import AXIS_MODELS, MODELS, known_model
from rollbench.compare.reference import parallel
from rollbench.compare.reference.jobs import Engine, first_here
from rollbench.compare.scenes import scene_file, scene_tables
from rollbench.compare.studies.sweep import sample
from rollbench.compare.studies.sweep.keys import Method, Vary, design_points, replaced_keys, values_at, with_varied_keys
from rollbench.compare.studies.sweep.sample import MAIN, OUTPUTS, refusal_reason, solve_batch, solve_sample_or_refuse
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly

#: Function that shows a line of progress.
Step = Callable[[str], None]
#: Number of samples of a design from which on compiled kernels are used; for so many, plain Python takes about as long as
#: compiling the kernels.
COMPILE_FROM = 50
#: Number of samples that are tried before anything is stored: if all are refused for the same reason, the sweep ends.
FIRST = 10
#: Largest number of samples that one job solves and stores together; smallest number of jobs per worker.
LARGEST_BATCH, BATCHES = 20, 20
#: Assumed number of workers of a cluster if none is given, as workers can join at any time.
MANY = 100


@dataclass(frozen=True)
class Sweep:
    """Definition of a sweep: scene, varied keys, design of the samples, model and outputs."""

    #: Text of the scene file.
    text: str
    #: File or scene that error messages name.
    origin: str
    #: Varied keys.
    keys: tuple[Vary, ...]
    #: Number of samples.
    samples: int
    #: Design of the samples.
    method: Method = "sobol"
    #: Seed of the design.
    seed: int = 0
    #: Name of the model.
    model: str = "refined"
    #: Outputs that are computed; empty: all.
    outputs: tuple[str, ...] = ()

    @property
    def wanted_outputs(self) -> tuple[str, ...]:
        """Outputs that are stored, in the order of `OUTPUTS`: all unless some are named, `MAIN` in any case."""
        return tuple(name for name in OUTPUTS if not self.outputs or name in (MAIN, *self.outputs))

    def coordinates(self) -> Array:
        """Return the coordinates of all samples in the unit cube, (m, d)."""
        return design_points(self.method, self.keys, self.samples, self.seed)

    def header(self) -> dict[str, Any]:
        """Return everything on which the records of the samples depend, as JSON values."""
        names = ("samples", "method", "seed", "model")
        what = {"scene": self.origin, "text": self.text, "vary": [vary.text for vary in self.keys]}
        some: dict[str, Any] = {"outputs_kept": list(self.wanted_outputs)} if self.outputs else {}
        if self.model not in MODELS:
            some["model_of"] = user_models.origin_of_model(self.model)
        return {"rollbench": __version__, **what, **{name: getattr(self, name) for name in names}, **some}

    def check(self) -> None:
        """Raise InputError for an unknown model or output, a key that the scene does not have, or values out of range."""
        for name in self.outputs:
            if name not in OUTPUTS:
                raise ArgumentError("outputs", name, ", ".join(OUTPUTS), "give names separated by commas")
        raw = scene_file.read_toml(self.text, self.origin)
        scene = scene_tables.read_tables(raw, self.origin)
        if not isinstance(scene, Assembly):
            known_model(self.model, without=("condensed",))
        elif self.model not in AXIS_MODELS:
            raise ArgumentError("model", self.model, ", ".join(AXIS_MODELS), "choose one of these")
        scene_file.each_case(scene, self.origin)
        for vary in self.keys:
            for value in vary.trial_values:
                scene_tables.keys_of(with_varied_keys(raw, [vary], [value]), self.origin)


def run_samples(sweep: Sweep, folder: Path, engine: Engine, step: Step) -> dict[int, sample.Record]:
    """Solve all samples of a sweep that its folder does not hold yet.

    Parameters
    ----------
    sweep
        Definition of the sweep.
    folder
        Folder with the stored samples.
    engine
        Where samples are computed: number of processes or cluster.
    step
        Called with lines of progress.

    Returns
    -------
    dict
        Records of all samples by their numbers.

    Raises
    ------
    InputError
        If the sweep is not valid, the folder holds something else, or workers are lost.
    """
    sweep.check()
    places = sweep.coordinates()
    if not sample.records_by_sample(folder):
        _refuse_hopeless_sweep(sweep, places)
    for path, other in replaced_keys(scene_file.read_toml(sweep.text, sweep.origin), sweep.keys):
        step(f"{path} takes the place of the scene's {other}")
    sample.open_folder(folder, sweep.header())
    with sample.take_folder(folder) as token:
        have = sample.records_by_sample(folder)
        left = [n for n in range(len(places)) if n not in have]
        step(f"{len(places)} samples, {len(have)} stored in {folder}, {len(left)} to solve")
        if left:
            _solve_missing(sweep, folder, engine, step, (token, places, left))
            have = sample.records_by_sample(folder)
    return have


def _refuse_hopeless_sweep(sweep: Sweep, places: Array) -> None:
    """Solve the first samples until one is accepted; raise InputError if all are refused for the same reason.

    ``places``: coordinates of all samples in the unit cube (m, d).
    """
    refused: list[InputError] = []
    for place in places[:FIRST]:
        try:
            solve_sample_or_refuse(
                sweep.text,
                sweep.origin,
                sweep.keys,
                values_at(sweep.keys, place),
                sweep.model,
                "interpreted",
                sweep.wanted_outputs,
            )
            return
        except InputError as error:
            refused.append(error)
    if len({refusal_reason(error) for error in refused}) > 1:
        return
    if isinstance(refused[-1], ProgramError):
        raise refused[-1]
    few = f"each of the first {min(FIRST, len(places))} samples is refused for the same reason, the last one as follows"
    raise Refusal(sweep.origin, "vary", f"{few}: {refused[-1]}", "vary other keys, or other ranges")


def _solve_missing(sweep: Sweep, folder: Path, engine: Engine, step: Step, work: tuple[str, Array, list[int]]) -> None:
    """Solve the missing samples in batches and store them.

    ``folder``: folder of the sweep; ``engine``: where samples are computed; ``step``: called with lines of progress;
    ``work``: token of the run, coordinates of all samples (m, d), numbers of the missing ones.
    """
    token, places, left = work
    kernels = "compiled" if len(places) >= COMPILE_FROM else "interpreted"
    what = (sweep.text, sweep.origin, sweep.keys, sweep.model, kernels, sweep.wanted_outputs)
    workers = engine.workers or (MANY if engine.scheduler else 1)
    size = max(1, min(LARGEST_BATCH, len(left) // (BATCHES * workers)))
    batches = [left[k : k + size] for k in range(0, len(left), size)]
    jobs: list[parallel.Job] = [
        (solve_batch, (str(folder.resolve()), token, what, [(n, values_at(sweep.keys, places[n])) for n in batch]))
        for batch in batches
    ]
    writer = sample.RecordWriter(folder, token)
    done = failed = 0
    for _, (records, stored) in first_here(jobs, engine, "samples", step):
        if not stored:
            writer.append(records)
        done += len(records)
        failed += sum(record["status"] != "converged" for record in records)
        step(f"[{done}/{len(left)}] {failed} failed")
