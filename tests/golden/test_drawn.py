"""Numbers of scenes that are drawn by seeds, as no shipped one is: they walk the rare branches, and guard against change.

Of each scene a row is kept: how it ended in words, and of each name in its results a weighted mean. A number is kept only
where a modulus that differs by `SHIFT` hardly moves it, so that no round-off is. Whoever changes them on purpose writes
them again with ``python -m tests.golden.test_drawn [KIND ...]`` and says why in the commit.
"""

import json
import re
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.campaign import draw as extreme
from tests.campaign.check_axes import HELD
from tests.campaign.draw_axes import axis_text
from tests.golden.means import answered, numbers_by_name

from rollbench.compare.errors import InputError, SceneNotCoveredError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.results.solved import Result
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.kinds import friction_scene_kinds
from rollbench.compare.studies import survey
from rollbench.meshes.axis import Assembly

RECORD = Path(__file__).parent / "drawn_scenes.json"
SEED = 1719
OTHERS = ("lin-cell", "lin-nut", "refined", "source", "mei", "mei-nut", "lin-source-partition")
ELASTIC, PLAIN = ("refined", "lin-nut", "lin-cell"), ("lin", "source", "mei", "mei-nut")
#: Share of the moduli by which they differ for the choice of what is kept, and by which that may move; tolerance of a test.
SHIFT, STEADY, TOLERANCE = 1e-11, 1e-8, 1e-6
#: Difference of a number, in its unit, that is round-off of forces and lengths that cancel.
NOISE = 1e-12
#: Time, memory, round-off and how a solver went.
LEFT_OUT = re.compile(
    r"second|residual|iteration|memory|MB|version|balance|equilibrium|round_off|evaluations|ball$|upwind|solver"
    r"|change$|_error$|imbalance|goal|rounds|steps$|slack|\.state|remainder|^\.summary\.friction$"
)
MODULUS = re.compile(r'(youngs_modulus = ")([\d.]+)')
WITHOUT_MESH_ERROR = ModelOptions(estimate_beam_mesh_error=False)
Found = tuple[str, dict[str, list[float]]]


def weighted(value: Any) -> dict[str, list[float]]:
    """Of each name below a value: a mean weighted by the places of its finite numbers, and mean size."""
    numbers = numbers_by_name(value, LEFT_OUT.search, properties=True)
    out = {}
    for name, every in numbers.items():
        x = every[np.isfinite(every)]
        if x.size:
            out[name] = [float((x * (1.5 + np.cos(np.arange(x.size)))).mean()), float(np.abs(x).mean())]
    return out


def shifted(text: str, shift: float) -> str:
    """A scene file with other moduli of elasticity."""
    return MODULUS.sub(lambda m: f"{m[1]}{float(m[2]) * (1.0 + shift):.16g}", text)


def screw(number: int, most: int) -> str:
    """Extreme screw or bearing of few balls: the first of some that are drawn for its number."""
    texts = (extreme.scene_text(SEED, 100 * number + k) for k in range(100))
    return next(text for text in texts if int(re.search(r"count = (\d+)", text)[1]) <= most)


def usual(number: int) -> str:
    """Screw as catalogues have it; each sixth with a flange."""
    text = survey.random_screw_scene_text(SEED, number + (survey.TUBES if number % 6 == 5 else 0))
    return text.replace('name = "bearing steel"', 'youngs_modulus = "208 GPa"\npoissons_ratio = 0.3')


def axis(number: int) -> str:
    """Several sets on one shaft."""
    return axis_text(SEED, number)


def rubbing(text: str, number: int) -> str:
    """A scene with coefficients of friction and a motion."""
    rng = np.random.default_rng([SEED, 7, number])
    mu = rng.choice([1e-3, 0.05, 0.1, 0.3], 3)
    same = rng.random() < 0.5
    text += "\n[friction]\n" + (f"coefficient = {mu[0]}\n" if same else f"screw = {mu[0]}\nnut = {mu[1]}\n")
    text += f"balls = {mu[2]}\n" * (rng.random() < 0.5)
    text += f"feedback = {str(bool(rng.random() < 0.5)).lower()}\nneighbours = {str(bool(rng.random() < 0.6)).lower()}\n"
    speed, turns = rng.choice([-600, 30, 2000]), rng.choice(["screw", "screw", "nut"])
    text += f'[motion]\nspeed = "{speed} rpm"\nturns = "{turns}"\n'
    return text


def in_time(number: int) -> str:
    """A usual screw that rubs, its balls run in time."""
    rng = np.random.default_rng([SEED, 6, number])
    text = rubbing(usual(300 + number), number)
    text += f"[circulation]\nreturning = {rng.integers(4)}\nfilling = {rng.uniform(0.6, 0.8):.2f}\n"
    text += f'[time]\nangle = "{rng.choice([3, 20])} deg"\nsteps = {rng.integers(4, 7)}\n'
    return text + 'output = "balls"\n' * (number % 2)


def cases(number: int) -> str:
    """A usual screw with two load cases, and a third one of no share."""
    rng, text = np.random.default_rng([SEED, 5, number]), usual(100 + number)
    for name, share in zip("abc", (0.3, 0.7, 0.0), strict=True):
        force = ", ".join(f'"{x:.4g} N"' for x in rng.normal(size=3) * (100.0, 100.0, 2000.0) * (rng.random(3) < 0.6))
        text += f'\n[[cases]]\nname = "{name}"\nshare = {share}\n'
        text += f'[[cases.loads]]\nat = "0 mm"\nforce = [{force}]\n'
    return text


def outcome_of(words: str) -> str:
    """Which outcome a status or refusal states, without its reason: "not held" and the motion; error, file and key."""
    parts = words.strip().partition(": got ")[0][:90].split(": ")
    return ": ".join(parts[: {"converged": 1, "not converged": 1, "not held": 2}.get(parts[0], 3)])


def answer(text: str, command: str) -> Found:
    """What a command answers as JSON for a scene file, or the beginning of its refusal."""
    name, *options = command.split()
    code, out, unsaid = answered([name, "drawn.toml", *options], text)
    return f"{code} {outcome_of(out.get('status', '' if '--members' in options else unsaid))}", weighted(out)


def tried(text: str, model: str) -> Found:
    """How a model ends with a scene file, and the numbers of its result."""
    try:
        value = solved(text, model)
    except (InputError, SceneNotCoveredError, ValueError) as error:
        return outcome_of(f"{type(error).__name__}: {error}"), {}
    return outcome_of(str(getattr(value[0] if isinstance(value, tuple) else value, "status", "done"))), weighted(value)


def solved(text: str, model: str) -> Any:
    """A result, with all answers for one set of balls that bears loads."""
    described = scene_file.parse_scene(text, "drawn.toml")
    if isinstance(described, Assembly):
        several = run_model(described, model, WITHOUT_MESH_ERROR)
        loose = next((text for text in several.left_out if HELD in text), "")
        if re.search("u[xyz]|r[xy]", loose):  # round-off decides where it comes to rest
            return several.status, [s.loads for s in several.sets]
        return several
    scene = scene_file.single_nut_scene_or_raise(described, "drawn.toml")
    return answers(solve_with_results(scene, model, WITHOUT_MESH_ERROR))


def answers(found: Result) -> Any:
    """The solution, and what follows from it for each nut or bearing and for the whole scene."""
    if not found.converged:
        return found.solution
    names = [f.name for f in fields(SetResult) if f.name not in ("parts", "balls", "on_shaft", "nominal_contacts")]
    each = [{name: getattr(s, name) for name in (*names, "life_by_loads")} for s in found.sets.values()]
    each[0]["shaft"] = found.shaft
    whole = {name: getattr(found, name) for name in ("axial", "nut", "load_point", "displacement", "load_path")}
    return found.solution, each, {"whole": whole}


def of_kind(number: int) -> str:
    """A shipped scene of a kind that only friction solves, its sizes changed by some per cent each."""
    rng, names = np.random.default_rng([SEED, 15, number]), sorted(n for n in catalogue.scene_names() if of_a_kind(n))
    return re.sub(
        r'"(-?[\d.]+) (mm|um|N|kN|deg|mm/s|rpm)"',
        lambda m: f'"{float(m[1]) * (1.0 + rng.uniform(-0.06, 0.06)):.9g} {m[2]}"',
        catalogue.shipped_scene_text(names[number % len(names)]),
    )


def of_a_kind(name: str) -> bool:
    """Whether only friction solves a shipped scene, in little time."""
    return catalogue.top_level_keys(name).get("kind") in friction_scene_kinds() and not name.startswith("lin-screw-run")


#: Of each kind: what draws the scene of a number, models that solve it in turns or a command, and how many there are.
ITEMS: dict[str, tuple[Callable[[int], str], tuple[str, ...] | str, int]] = {
    "extreme": (lambda n: screw(n, 60), ("lin",), 120),
    "extreme, other models": (lambda n: screw(1000 + n, 16), OTHERS, 63),
    "axes": (axis, ("lin",), 90),
    "axes, refined": (lambda n: axis(1000 + n), ELASTIC, 18),
    "axes, commands": (lambda n: axis(2000 + n), "solve --model lin", 16),
    "usual": (usual, PLAIN, 48),
    "usual, refined": (lambda n: usual(24 + n), "solve", 6),
    "cases": (cases, "solve --model lin --balls", 4),
    "members": (lambda n: usual(40 + n), "solve --members 5 --model lin", 5),
    "friction of extremes": (lambda n: rubbing(screw(2000 + n, 12), n), "friction --model lin", 50),
    "friction": (lambda n: rubbing(usual(60 + n), n), "friction --model lin", 16),
    "friction of axes": (lambda n: axis(3000 + n), "friction --model lin --mu 0.1", 12),
    "friction in time": (in_time, "friction --model lin", 6),
    "friction of kinds": (of_kind, "friction", 32),
}


def made(name: str, number: int, shift: float = 0.0) -> Found:
    """How an item of a kind ended, and its numbers, with other moduli."""
    draw, how, _ = ITEMS[name]
    text = shifted(draw(number), shift)
    return answer(text, how) if isinstance(how, str) else tried(text, how[number % len(how)])


def row(name: str, number: int) -> tuple[str, dict[str, float | None]]:
    """How an item ended, and its numbers that round-off does not move."""
    (words, first), (again, second) = (made(name, number, shift) for shift in (0.0, SHIFT))
    if words != again or first.keys() != second.keys():
        return "", {}
    steady = {key: abs(value - second[key][0]) <= STEADY * size for key, (value, size) in first.items()}
    return words, {key: float(f"{value:.9g}") for key, (value, _) in first.items() if steady[key]}


def written(name: str) -> dict[str, Any]:
    """The record of a kind: names of numbers, and a row of each item: its words, then its numbers by these names."""
    rows = [row(name, number) for number in range(ITEMS[name][2])]
    names = list(dict.fromkeys(key for _, numbers in rows for key in numbers))
    return {"names": names, "rows": [[words, *(numbers.get(key) for key in names)] for words, numbers in rows]}


#: How many items one test solves: those of friction take some ten seconds each.
AT_ONCE = {"friction": 4, "friction in time": 1}
BLOCKS = [(name, begin) for name, (*_, count) in ITEMS.items() for begin in range(0, count, AT_ONCE.get(name, 40))]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "begin"), BLOCKS)
def test_no_number_of_a_drawn_scene_moves(name, begin):
    record = json.loads(RECORD.read_text(encoding="utf-8"))[name]
    assert len(record["rows"]) == ITEMS[name][2]
    for number, (words, *kept) in list(enumerate(record["rows"]))[begin : begin + AT_ONCE.get(name, 40)]:
        said, found = made(name, number)
        assert not words or said == words, number
        for key, value in zip(record["names"], kept, strict=True):
            if value is not None:
                noise = max(TOLERANCE * found[key][1], NOISE)
                assert found[key][0] == pytest.approx(value, rel=TOLERANCE, abs=noise), (number, key)


if __name__ == "__main__":
    old = json.loads(RECORD.read_text(encoding="utf-8")) if sys.argv[1:] else {}
    found = {name: written(name) if name in (sys.argv[1:] or ITEMS) else old[name] for name in ITEMS}
    lines = []
    for name, own in found.items():
        rows = ",\n".join(json.dumps(one, separators=(",", ":")) for one in own["rows"])
        lines.append(f'{json.dumps(name)}: {{"names": {json.dumps(own["names"])},\n"rows": [\n{rows}]}}')
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
