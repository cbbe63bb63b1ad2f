"""Two explanations of the model error of 5.38 % that section 2.4.1 of Lin's thesis prints, and what each of them misses.

The thesis leaves inputs of the low-order model and of the 3D model open. One explanation assumes a section constant without
root and beam elements of 15 mm in the low-order model, and a plain shaft beyond the nut in 3D.

The other one has softer contacts in 3D. The text states that these use an augmented Lagrangian, with all other settings by
default. This leaves a penetration by a penalty that is not printed (`rollbench.compare.cases.lin.reconstruction.solvers`).
The natural size of the penalty is E/h, with E Young's modulus and h the size of Lin's elements; penalties of this size and
smaller are computed.

Six numbers are printed: the ratio of largest to smallest load "about 1.34" for both models, and four errors of one model
against the other. Each explanation is shown with its deviations from these numbers; none is claimed to be what Lin did. No
model reads a printed number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.cases.lin.reconstruction.solvers import solve_with_penalty_contacts
from rollbench.compare.measure import error_percent, load_error, mean_load
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.levels import with_plain_shaft
from rollbench.compare.reference.store import Run, load_stored_run, save_run
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Scenes of the cases whose errors are printed.
CASES = ("lin-case1", "lin-case2")

#: Mesh levels of 3D solutions without and with a penalty.
LEVEL, PENALTY_LEVEL = 1, 2

#: Keys of the printed errors, in the order of the values of `ExplanationResult.errors_percent`.
ERRORS = ("case1_max_error", "case1_rms_error", "case2_max_error", "case2_rms_error")

#: Folder of the stored 3D results.
RUNS = Path(__file__).parent / "runs"


@dataclass(frozen=True)
class Explanation:
    """Assumptions on what Lin's thesis leaves open, which may explain the errors that it prints."""

    #: Name of the explanation in tables.
    name: str
    #: Name by which its 3D results are stored.
    run: str
    #: Assumptions on the low-order model, in words.
    low_order: str = "as by default"
    #: Assumptions on the 3D model, in words.
    in_3d: str = "as by default"
    #: Options of the low-order model that differ from the default, by their names.
    options: Mapping[str, Any] = field(default_factory=dict, hash=False)
    #: Function that changes a scene for the 3D model.
    change_scene: Callable[[Scene], Scene] = lambda scene: scene
    #: Contact penalty in 3D over E/h (E: Young's modulus, h: size of Lin's elements); 0: no penetration.
    penalty: float = 0.0

    @property
    def level(self) -> int:
        """Mesh level of the 3D model."""
        return PENALTY_LEVEL if self.penalty else LEVEL

    def scenes_in_3d(self) -> list[Scene]:
        """Return the scenes of Lin's cases 1 and 2 for the 3D model."""
        return [replace(self.change_scene(catalogue.scene(c)), name=f"{c}-{self.run}") for c in CASES]


def _softer_contacts(run: str, size: str, penalty: float) -> Explanation:
    """Return the explanation by contacts that a penalty softens; ``size``: the penalty in words, ``penalty``: over E/h."""
    words = f"penalty of the 3D contacts: {size}"
    return Explanation(words, run, in_3d=words.replace("3D ", ""), penalty=penalty)


DEFAULT = Explanation("all by default", "base")
PLAIN_SHAFT = Explanation(
    "section constant, beam elements and plain shaft",
    "plain",
    "section constant (C.8): C.8 without its root; beam elements in the nut: 15 mm, as printed",
    "shaft beyond the nut: plain, of the lands' diameter",
    {"section": "groove squared", "partition": "source"},
    with_plain_shaft,
)
SOFT = (
    _softer_contacts("penalty", "E/h, h = 0.08 mm", 1.0),
    _softer_contacts("penalty-3", "a third of E/h", 1.0 / 3.0),
    _softer_contacts("penalty-4", "a quarter of E/h", 0.25),
    _softer_contacts("penalty-6", "a sixth of E/h", 1.0 / 6.0),
)
#: The penalty that is also computed on the next mesh level, to show the influence of the mesh.
FINER = SOFT[2]

#: All explanations, in the order of the report.
EXPLANATIONS = (DEFAULT, PLAIN_SHAFT, *SOFT)


@dataclass(frozen=True)
class ExplanationResult:
    """What an explanation gives: ratios of largest to smallest load in case 1, and errors of the low-order loads."""

    #: The explanation.
    of: Explanation
    #: Ratio of largest to smallest load by the low-order and by the 3D model.
    low_order_ratio: float
    ratio_in_3d: float
    #: Errors of low-order against 3D loads [% of each load]: largest and RMS error of case 1, then of case 2.
    errors_percent: tuple[float, ...]

    @property
    def deviations_from_print(self) -> Array:
        """Deviations from the printed numbers (6,): two load ratios [%], then four errors of loads [percentage points]."""
        ratios = error_percent(np.array([self.low_order_ratio, self.ratio_in_3d]), printed_load_ratio())
        return np.concatenate([ratios, np.array(self.errors_percent) - np.array(printed_errors_percent())])


def printed_load_ratio() -> float:
    """Return the ratio of largest to smallest load that Lin prints for both models: about 1.34."""
    return printed_value("lin-2.4.1", "case1_ratio")


def printed_errors_percent() -> tuple[float, ...]:
    """Return the four errors [%] against ANSYS that Lin prints: largest and RMS error of case 1, then of case 2."""
    return tuple(printed_value("lin-2.4.1", key) for key in ERRORS)


def load_ratio(load: Array) -> float:
    """Return the ratio of the largest to the smallest ball load on flank SL; ``load``: contact loads (n, 4) [N]."""
    return float(load[:, 0].max() / load[:, 0].min())


def low_order_errors_percent(cache: SceneResultCache, explanation: Explanation, runs: tuple[Run, ...]) -> tuple[float, ...]:
    """Return the errors of low-order against 3D loads [% of each load]: largest and RMS of case 1, then of case 2."""
    pairs = zip(low_order_loads(cache, explanation), runs, strict=True)
    return tuple(x for e in (load_error(a, run.load) for a, run in pairs) for x in (e.own_max_percent, e.own_rms_percent))


def low_order_loads(cache: SceneResultCache, explanation: Explanation) -> list[Array]:
    """Return the contact loads (n, 4) [N] of Lin's cases 1 and 2 by the low-order model; ``cache`` gives solved scenes."""
    scenes = [catalogue.scene(c) for c in CASES]
    changed = [replace(s, ingredients=replace(s.ingredients, **explanation.options)) for s in scenes]
    return [cache.solve_once(scene, "lin").load for scene in changed]


def runs_in_3d(explanation: Explanation, level: int | None = None) -> tuple[Run, ...]:
    """Return the stored 3D results of Lin's cases 1 and 2 for an explanation.

    ``level``: mesh level; None: that of the explanation. Raises LookupError if a result is not stored.
    """
    found = [load_stored_run(s, level or explanation.level, stores=[RUNS]) for s in explanation.scenes_in_3d()]
    runs = tuple(run for run in found if run is not None and run.status == "converged")
    if len(runs) < len(CASES):
        missing = f"no 3D results are stored for the explanation of Lin's errors {explanation.run!r}"
        raise LookupError(f"{missing}: run python -m {__package__}")
    return runs


def compute_missing_3d_results(step: Callable[[str], None], cache: Path | None = None) -> None:
    """Compute and store those 3D results of all explanations that are not stored yet.

    ``step``: function that receives a message before each solution; ``cache``: folder for intermediate results, None for no
    such folder. Raises ValueError if a solution does not converge.
    """
    for explanation, level in [*((e, e.level) for e in EXPLANATIONS), (FINER, PENALTY_LEVEL + 1)]:
        scenes = explanation.scenes_in_3d()
        if all(load_stored_run(scene, level, stores=[RUNS]) is not None for scene in scenes):
            continue
        step(f"3D: {explanation.run}, level {level}")
        if explanation.penalty:
            shipped = [load_stored_run(catalogue.scene(c), level) for c in CASES]
            begin = [run for run in shipped if run is not None]
            runs = solve_with_penalty_contacts(scenes, begin, explanation.penalty, cache)
        else:
            runs = compute_reference_runs(ReferenceTask(tuple(scenes), level, cache_folder=cache))
        for scene, run in zip(scenes, runs, strict=True):
            save_run(RUNS, scene, run)


def evaluate_explanations(cache: SceneResultCache) -> list[ExplanationResult]:
    """Return load ratios and model errors of each explanation in `EXPLANATIONS`.

    Raises LookupError if a 3D result is not stored. ``cache``: gives solved scenes.
    """
    found = []
    for explanation in EXPLANATIONS:
        runs, low = runs_in_3d(explanation), low_order_loads(cache, explanation)
        errors = low_order_errors_percent(cache, explanation, runs)
        found.append(ExplanationResult(explanation, load_ratio(low[0]), load_ratio(runs[0].load), errors))
    return found


def penalty_over_hertz_approach(explanation: Explanation) -> float:
    """Return the approach that a contact penalty adds in Lin's case 1, divided by the Hertz approach, at the mean load."""
    scene, still, moved = catalogue.scene(CASES[0]), runs_in_3d(DEFAULT)[0], runs_in_3d(explanation)[0]
    lead = np.arctan(scene.track.lead / (2.0 * np.pi * scene.track.pitch_radius))
    along = 0.5 * float((moved.centreline[:, 3] - still.centreline[:, 3]).mean())
    added = along * np.sin(scene.track.contact_angle) * np.cos(lead)
    return float(added / (np.mean(hertz_without_errors(scene).C[[0, 3]]) * mean_load(still.load) ** (2.0 / 3.0)))
