"""Answers of a solved scene: the block of eleven entries, its JSON, preload and lift-off, matrix files, the load curve."""

import io
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.io import mmread
from tests.campaign.draw_axes import axis_text
from tests.slow import all_slow_but

from rollbench.compare.commands.solve import SolveOptions, dmig_text, exit_code_of_solutions, matrix_market_text
from rollbench.compare.models.answers import tangent_stiffness_at
from rollbench.compare.models.comparison import SceneWithReference
from rollbench.compare.models.loading import (
    LiftOff,
    SolutionsByLoad,
    axial_load,
    find_lift_off_loads,
    preload_from_unloaded,
    solve_with_scaled_loads,
    with_scaled_loads,
)
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.reference.estimate import reference_of_scene
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.results.comparing import compare_models_with_reference
from rollbench.compare.results.friction import Friction
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.template import new_scene_text
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.lowfi.statics import equations, equilibrium
from rollbench.lowfi.warned import INPUT, REMARK, VALIDITY, Kind, ResultWarning
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, BallErrors, Errors, Scene

QUIET = ModelOptions(estimate_beam_mesh_error=False)


def lift_off_loads(scene: Scene | Assembly) -> tuple[LiftOff | None, ...]:
    """Loads that open a contact of each nut or bearing, by lin."""
    return find_lift_off_loads(SolutionsByLoad(scene, run_model(scene, "lin", QUIET), "lin", QUIET))


def test_preload_is_what_the_flanks_press_without_load() -> None:
    scene = catalogue.scene("lin-case3")
    found = solve_with_results(scene, "lin", QUIET)
    bare = solve_with_scaled_loads(scene, 0.0, "lin", QUIET)
    held = preload_from_unloaded(scene, bare)
    assert (held, held.contacts) == (found.preload, 4 * scene.ball_count)
    assert held.axial == pytest.approx(approach_per_displacement(scene) * bare.load[:, 0].sum(), rel=0.02)


@pytest.mark.parametrize(("oversize", "low", "high"), [(None, 1.0, np.inf), (2e-6, 0.0, 1.0)], ids=["shipped", "lighter"])
def test_the_first_contact_is_lost_where_lift_off_says(oversize: float | None, low: float, high: float) -> None:
    """Above the scene's load, and with less preload below it."""
    scene = catalogue.scene("lin-case3")
    if oversize:
        scene = replace(scene, errors=Errors(balls=BallErrors(oversize=oversize)))
    (found,) = lift_off_loads(scene)
    before, after = (solve_with_scaled_loads(scene, f * found.factor, "lin", QUIET).load for f in (0.98, 1.02))
    assert low < found.factor < high
    assert before.min() > 0.0
    assert after[found.ball - 1, SIDES.index(found.side)] == 0.0
    assert found.axial == pytest.approx(5000.0 * found.factor)


def test_without_preload_no_contact_is_lost() -> None:
    scene = catalogue.scene("lin-case1")
    assert lift_off_loads(scene) == (None,)


def test_nuts_that_just_touch_have_no_preload_to_lose(tmp_path) -> None:
    """Offsets that the housings give way to leave 1e-7 of the loads' contact forces, and each load near none minutes."""
    path = tmp_path / "touching.toml"
    path.write_text(axis_text(881402, 209), encoding="utf-8")
    assert lift_off_loads(catalogue.scene_of_any_kind(str(path))) == (None,) * 4


@pytest.mark.parametrize(
    ("name", "opening"), all_slow_but([("double-nut", 1)], [("double-nut", 1), ("axis-fixed-fixed", 3)])
)
def test_the_first_contact_of_every_set_is_lost_where_lift_off_says(name: str, opening: int) -> None:
    """The sets whose contacts open are the nut with play inside, and the rows that the load relieves."""
    scene = catalogue.scene_of_any_kind(name)
    found = [(k, x) for k, x in enumerate(lift_off_loads(scene)) if x is not None and x.factor is not None]
    assert len(found) == opening
    idle = run_model(with_scaled_loads(scene, 0.0), "lin", QUIET).sets
    for k, x in found:
        preloaded = idle[k].loads > 0.0
        before, after = (
            run_model(with_scaled_loads(scene, f * x.factor), "lin", QUIET).sets[k].loads for f in (0.99, 1.01)
        )
        assert before[preloaded].min() > 0.0
        assert after[x.ball - 1, SIDES.index(x.side)] == 0.0
        assert preloaded[x.ball - 1, SIDES.index(x.side)]
        assert (x.set, x.axial) == (scene.sets[k].name, pytest.approx(axial_load(scene) * x.factor))


def test_matrix_files_hold_the_matrix() -> None:
    rng = np.random.default_rng(1)
    a = rng.normal(size=(6, 6)) * 1e6
    matrix = a @ a.T
    np.testing.assert_allclose(mmread(io.StringIO(matrix_market_text(matrix, "a"))), matrix, rtol=1e-14)
    read = np.zeros((6, 6))
    column = -1
    for line in dmig_text(matrix, "a comment").splitlines():
        if line.startswith("DMIG*"):
            column = int(line[40:56]) - 1
        elif line.startswith("*"):
            row = int(line[24:40]) - 1
            read[row, column] = read[column, row] = float(line[40:56].replace("D", "E"))
    np.testing.assert_allclose(read, matrix, rtol=1e-9)


@pytest.mark.parametrize("model", ["lin", "source"])
def test_tangents_and_matrix_are_answered_for_more_balls_than_elastic_bodies_take(monkeypatch, command, model) -> None:
    monkeypatch.setattr(equations, "LARGEST", 20)
    words = "solve", "lin-case1", "--model", model
    assert command.answer(*words)["summary"]["nut"]["tangent_N_per_um"] > 0.0
    assert tangent_stiffness_at(catalogue.scene("lin-case1"), 0.4, model, QUIET).matrix[2, 2] > 0.0


#: A result's keys under which numbers stand that are answers.
ANSWERS = ("balls", "rollers", "sets", "housings", "centreline", "equilibrium", "stiffness", "summary")
#: Keys of rows that say which and where, and are known without a solution.
PLACES = ("set", "index", "name", "kind", "azimuth_deg", "z_mm", "position_mm", "housing", "offset_um")


def numbers(value) -> list[float]:
    """All numbers under a value but those of places."""
    if isinstance(value, dict):
        return [x for key, v in value.items() if key not in PLACES for x in numbers(v)]
    if isinstance(value, list):
        return [x for v in value for x in numbers(v)]
    return [value] if isinstance(value, int | float) else []


SHORT = ("count = 68\nturns = 4.3", "count = 8\nturns = 1.5")
SOLVERS = [("lin-case3", "lin"), ("bearing-9", "refined"), ("double-nut", "lin"), ("double-nut", "refined")]


@pytest.mark.parametrize(("name", "model"), all_slow_but(SOLVERS[:2], SOLVERS))
def test_what_did_not_converge_prints_no_numbers_as_answers(monkeypatch, command, scene_file, name, model) -> None:
    changes = (SHORT, SHORT) if name == "double-nut" else ()
    words = "solve", scene_file(catalogue.shipped_scene_text(name), *changes), "--model", model
    whole = command.answer(*words)
    monkeypatch.setattr(equilibrium, "MAX_ITERATIONS", 1)
    code, data = command.json(*words, "--json")
    assert (code, data["status"][:13]) == (1, "not converged")
    assert data.keys() == whole.keys()
    assert numbers(whole["balls"])
    assert not [key for key in ANSWERS if numbers(data.get(key))]
    code, text, _ = command(*words, "--balls")
    assert code == 1
    assert not [line for line in text.splitlines() if re.search(r"\d\.\d+ (N|um)", line)]


SCREW, SETS = new_scene_text("ball screw", "40x10"), catalogue.shipped_scene_text("double-nut")
BENT = '"800 mm"\nfix = ["ux", "uy"]', '"800 mm"\nfix = ["ux"]\ndisplace = { uy = "40 mm" }'
#: Text of a scene, its changes, and what the line above the answers says.
OUTSIDE = {
    "as written": (SCREW, (), ()),
    "oversize": (SCREW, ('force = "5 % of C"', 'oversize = "60 um"'), ("contact pressure", "static safety", "above C =")),
    "load": (SCREW, (', "5.7 kN"]', ', "900 kN"]'), ("contact pressure", "below 1")),
    "open screw": (SCREW, ("conformity = 0.525  #", "conformity = 1.05  #"), ("conformity above 0.6 (screw 1.05)",)),
    "widest nut's": (SCREW, ("conformity = 0.525\n", "conformity = 0.6\n"), ()),
    "wider nut's": (SCREW, ("conformity = 0.525\n", "conformity = 0.61\n"), ("conformity above 0.6 (nut",)),
    "bent": (SCREW, BENT, ("rotations of",)),
    "flat": (
        new_scene_text("ball screw", "36x16"),
        ('"45 deg"', '"5 deg"'),
        ("beyond the groove's arc", "one contact counted twice"),
    ),
    "several sets": (SETS, ('offset = "-4 um"', 'offset = "-120 um"'), ("models mean: nut 1: ", "nut 2: preload")),
}


@pytest.mark.parametrize("name", [pytest.param(x, marks=pytest.mark.slow) if x == "several sets" else x for x in OUTSIDE])
def test_a_line_above_the_answers_says_what_leaves_the_models(scene_file, command, name) -> None:
    text, change, said = OUTSIDE[name]
    words = "solve", scene_file(text, *[change] * bool(change)), "--model", "lin"
    lines = command.said(*words).splitlines()
    head = " ".join(lines[: next(k for k, line in enumerate(lines) if line.startswith("quantity "))])
    assert ("WARNING" in head) is bool(said)
    assert all(word in head for word in said), head
    assert sum("WARNING" in line for line in lines) == bool(said)
    code, data = command.json(*words, "--strict", "--json")
    assert (code, data["warning"] is not None) == (bool(said), bool(said))
    assert len(data["warnings"]) >= len(said)


@pytest.mark.parametrize("kind", [*VALIDITY, *INPUT, *REMARK])
def test_strict_ends_with_1_on_every_kind_of_warning_but_remarks(kind: Kind) -> None:
    """Whether or not the warning has a short form of its own; in `solve` and `friction`, which print the same line."""
    counts = kind in (*VALIDITY, *INPUT)
    for warned in (ResultWarning(kind, "text"), ResultWarning(kind, "text", "short").with_part_name("nut 1")):
        solved = SimpleNamespace(converged=True, solution=SimpleNamespace(warnings=(warned,)))
        codes = [exit_code_of_solutions([solved], SolveOptions("lin", strict=strict)) for strict in (False, True)]
        assert codes == [0, int(counts)]
        line = Friction(scene="", title="", kind="", converged=True, reason="", warnings=(warned,), keys=()).warning
        assert (bool(line), "outside what the models mean" in line) == (counts, kind in VALIDITY)


@pytest.mark.slow
def test_a_life_is_said_in_hours_and_kilometres_too(scene_file, command) -> None:
    """1200 rpm, lead 10 mm; several sets; a screw without a speed; a ring without a lead; a cycle at its mean speed."""

    def life(scene) -> dict[str, float]:
        return command.answer("solve", scene, "--model", "lin")["summary"]["life"]

    found = life(scene_file(SCREW, ("[balls]\n", '[motion]\nspeed = "1200 rpm"\n\n[balls]\n')))
    revolutions = 1e6 * found["L10_million_revolutions"]
    assert (found["L10_hours"], found["L10_km"]) == pytest.approx((revolutions / 72_000.0, revolutions * 1e-5))
    sets = command.answer("solve", "double-nut", "--model", "lin")
    speed = catalogue.scene_of_any_kind("double-nut").motion.speed / (2.0 * np.pi)
    for found in (sets["summary"]["life"], *(one["summary"]["life"] for one in sets["sets"])):
        assert found["L10_hours"] == pytest.approx(1e6 * found["L10_million_revolutions"] / speed / 3600.0)
    still = life(scene_file(SCREW))
    assert ("L10_hours" in still, still["L10_km"] > 0.0) == (False, True)
    assert life("bearing-9")["L10_km"] is None
    case = '[[cases]]\nname = "a"\ntime = "1 s"\nspeed = "600 rpm"\n'
    found = life(scene_file(SCREW, ("# [friction]", f"{case}\n# [friction]")))
    assert found["L10_hours"] == pytest.approx(1e6 * found["L10_million_revolutions"] / 36_000.0)


MODULI = [("210 MPa", 2), ("0.99 GPa", 2), ("1 GPa", 0), ("1001 GPa", 2), ("70 GPa", 0)]


@pytest.mark.parametrize(("modulus", "code"), MODULI)
def test_a_modulus_of_no_solid_is_refused_unless_it_is_meant(scene_file, command, modulus: str, code: int) -> None:
    light = (('force = "5 % of C"', 'oversize = "0.1 um"'), (', "5.7 kN"]', ', "100 N"]'))
    for meant, expected in (("", code), ("unusual = true\n", 0)):
        material = f'{meant}youngs_modulus = "{modulus}"\npoissons_ratio = 0.3'
        file = scene_file(SCREW, ('name = "bearing steel"', material), *light)
        found, _, error = command("solve", file, "--model", "lin")
        assert found == expected
        assert bool(re.search("material.youngs_modulus.*1 GPa to 1000 GPa", error)) is bool(expected)


def test_compare_counts_displacements_from_where_solve_does() -> None:
    scene, stores = catalogue.scene("lin-case3"), (shipped_store(),)
    one = SceneWithReference(scene, reference_of_scene(scene, stores))
    whole = compare_models_with_reference(one, [MODELS["lin"]], stores)
    solved = solve_with_results(scene, "lin", QUIET)
    assert whole.models["lin"].displacement == pytest.approx(solved.displacement[2], rel=1e-9)
    assert whole.unloaded_position != 0.0
    loads = whole.reference
    bare = np.interp(scene.loads[0].at, loads.contact_loads.stations, loads.contact_loads.line[:, 2])
    assert loads.displacement == pytest.approx(bare - whole.unloaded_position, rel=1e-12)
