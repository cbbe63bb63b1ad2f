"""Random extreme scenes solved by a model, each outcome judged: right, refused with proof, or a fault of this project."""

import json
import re
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from tests.axes import one_set
from tests.campaign import check, check_axes
from tests.campaign.draw import scene_text
from tests.campaign.draw_axes import axis_text

from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.models.many import StoredIn, solve_many
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.provenance import sources_hash
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import extremes
from rollbench.lowfi.statics.result import AxisResult, StaticResult, StaticSolution
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Load, Scene

#: Packages whose sources an outcome depends on.
PACKAGES = ("meshes", "lowfi", "compare")
WITHOUT_MESH_ERROR = ModelOptions(estimate_beam_mesh_error=False)
#: Less energy that plain minimisation may find, over the energy stored in the contacts.
LOWER = 1e-6
#: Tokens of a command to its exit code and what it prints; the line that it refuses with for exit code 2.
Command = Callable[[list[str]], tuple[int, str]]
#: Loads that a command prints may differ from the model's by this share of the largest.
SAME = 1e-5


def misstated(text: str, model: str, found: StaticSolution | InputError, command: Command) -> str:
    """What ``rollbench solve`` says of a scene file otherwise than the model did, in words; empty where all agree."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "campaign.toml"
        path.write_text(text, encoding="utf-8")
        tokens = ["solve", str(path), "--model", model, "--balls"]
        (printed, words), (code, answer) = command(tokens), command([*tokens, "--json"])
    expected = 2 if isinstance(found, InputError) else 1 - found.converged
    if (printed, code) != (expected, expected):
        return f"exit codes {printed} (text) and {code} (JSON) instead of {expected}: {answer if code == 2 else words}"
    if isinstance(found, InputError):
        return ""
    if found.status not in " ".join(words.split()):
        return "the text does not say the status"
    if number := re.search(r"(?<![\w.])[+-]?(nan|inf)\b", words):
        return f"the text says {number[0]}"
    try:
        data = json.loads(answer, parse_constant=_refuse)
    except ValueError as error:
        return f"no strict JSON: {error}"
    if data["status"] != found.status:
        return f"the JSON's status is {data['status']}"
    rows = [[row["load_N"][side] for side in SIDES] for row in data["balls"]]
    load = np.array(rows, dtype=float).reshape(-1, 4)  # null becomes nan
    known = np.concatenate([np.zeros((0, 4)), *(b.load for b in found.ball_results())])
    same = np.allclose(load, known, rtol=0.0, atol=SAME * float(np.nanmax(known, initial=0.0)), equal_nan=True)
    return "" if same else "the JSON's loads are others"


def _refuse(word: str) -> Any:
    raise ValueError(f"{word} is no JSON number")


@dataclass(frozen=True)
class Outcome:
    """One scene: its number, what became of it, in words, the seconds, and whether it was compared by brute force."""

    number: int
    verdict: str
    words: str
    seconds: float
    brute: bool = False


@dataclass(frozen=True)
class Campaign:
    """``count`` scenes of one set, or of several on one shaft (``axes``), drawn by a seed and solved by a model, ``files``
    mutated scene files and half as many stored ones, and ``kills``. command: the command line, through which every scene
    goes too, as text and as JSON."""

    seed: int
    count: int
    model: str = "lin"
    files: int = 0
    kills: int = 0
    axes: bool = False
    command: Command | None = None


def placed(error: Exception) -> str:
    """An exception in words, with the place where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({place.name}, line {place.lineno})"


def judge(
    seed: int, number: int, model: str, command: Command | None = None, draw: Callable[[int, int], str] = scene_text
) -> Outcome:
    """Draw a scene, solve it and judge the outcome, what ``command`` (if given) prints of it too; whatever happens is an
    outcome, never an exception."""
    begin = perf_counter()
    try:
        verdict, words, brute = _judged(draw(seed, number), model, command)
    except Exception as error:  # a traceback is what the campaign looks for
        verdict, words, brute = extremes.CRASHED, placed(error), False
    return Outcome(number, verdict, words, perf_counter() - begin, brute)


def _judged(text: str, model: str, command: Command | None) -> tuple[str, str, bool]:
    found: StaticResult | AxisResult | InputError
    try:
        scene = scene_file.parse_scene(text, "campaign.toml")
        found = run_model(scene, model, WITHOUT_MESH_ERROR)
        of_kind = _of_axis if isinstance(scene, Assembly) else _of_scene
        verdict, words, brute = of_kind(scene, found, model)
    except InputError as error:
        named = isinstance(error, SceneError) or bool(error.key and error.value)
        found, verdict, words, brute = error, extremes.REFUSED if named else extremes.SILENT, str(error), False
    if command is not None and verdict in extremes.GOOD and (fault := misstated(text, model, found, command)):
        return extremes.MISSTATED, fault, brute
    return verdict, words, brute


def _of_axis(assembly: Assembly, result: AxisResult, model: str) -> tuple[str, str, bool]:
    """Verdict on several sets on one shaft."""
    cause = result.status.cause
    if result.converged:
        fault = check_axes.faults(assembly, result) if model == "lin" else ""
        if assembly.thermal_strain and not assembly.loads and not assembly.housings:
            fault = fault or _jump_by_a_small_load(assembly)
        return extremes.WRONG if fault else extremes.RIGHT, fault, False
    if result.status.kind != "not held":
        return extremes.SILENT, result.status, False
    posed = check_axes.as_mounted(assembly) if cause == "mounting" else assembly
    moves = cause != "crossed row" and check_axes.proven(assembly, cause == "mounting")
    return extremes.PROVEN if moves or (cause and _crosses(posed, model)) else extremes.UNPROVEN, result.status, False


def _jump_by_a_small_load(assembly: Assembly) -> str:
    """Fault of the model refined on a shaft that is only warm, if a load of a thousandth of a row's force changes any
    contact load by more than a hundredth of the largest: the answer is continuous in every load."""
    idle = MODELS["refined"].solve_assembly_or_reason(assembly, WITHOUT_MESH_ERROR)
    push = 1e-3 * max(float(np.abs(s.force).max()) for s in idle.sets) if idle.converged else 0.0
    if push == 0.0:
        return "" if idle.converged else f"refined: {idle.status}"
    loaded = replace(assembly, loads=(Load(assembly.sets[0].position, (0.0, 0.0, push)),))
    found = MODELS["refined"].solve_assembly_or_reason(loaded, WITHOUT_MESH_ERROR)
    before, after = (np.concatenate([s.loads.ravel() for s in r.sets]) for r in (idle, found))
    change = float(np.abs(after - before).max() / before.max()) if found.converged else np.inf
    return f"refined: a load of {push:.3g} N changes contact loads by {100.0 * change:.3g} %" if change > 0.01 else ""


def _crosses(assembly: Assembly, model: str) -> bool:
    """Whether the state with arcs that go on across the bottom is right, the only one then, and has a loaded ball there."""
    state = MODELS[model].solve_assembly_or_reason(assembly, WITHOUT_MESH_ERROR)
    right = state.status.cause == "crossed row" and not check_axes.faults(assembly, state)
    return right and check_axes.crossed(assembly, state)


def _of_scene(scene: Scene, result: StaticResult, model: str) -> tuple[str, str, bool]:
    """Verdict on one set."""
    if result.status.kind == "not held":
        proven = check_axes.proven(one_set(scene), False)
        return extremes.PROVEN if proven else extremes.UNPROVEN, result.status, False
    if not result.converged:
        return extremes.NOT_UNIQUE if result.status.cause == "not unique" else extremes.SILENT, result.status, False
    fault = check.unbalanced(scene, result) or (check.off_the_law(scene, result) if model == "lin" else "")
    lower = None if fault or model != "lin" else check.brute_force(scene, result)
    if lower is not None and lower > LOWER:
        fault = f"plain minimisation finds {lower:.2g} of the stored energy less"
    return extremes.WRONG if fault else extremes.RIGHT, fault, lower is not None


def judge_scenes(what: Campaign, folder: Path | None = None) -> Iterator[Outcome]:
    """The scenes of a campaign. folder: keeps their outcomes, so that an interrupted one goes on with equal sources."""
    draw = axis_text if what.axes else scene_text
    rows = {number: (what.seed, number, what.model, what.command, draw) for number in range(what.count)}
    stored = None
    if folder is not None:
        header = {"seed": what.seed, "model": what.model, "axes": what.axes, "sources": sources_hash(PACKAGES)}
        stored = StoredIn(folder, header, "--keep")
    for _, outcome in solve_many(_outcome_values, rows, noun="scenes", stored=stored):
        yield Outcome(**outcome)


def _outcome_values(*how: Any) -> dict[str, Any]:
    """Outcome of one scene by name, as it is stored."""
    return asdict(judge(*how))


def tally(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many outcomes of each kind, and how many were compared by brute force."""
    counts = {verdict: sum(o.verdict == verdict for o in outcomes) for verdict in (*extremes.GOOD, *extremes.BAD)}
    return counts | {"compared with plain minimisation": sum(o.brute for o in outcomes)}
