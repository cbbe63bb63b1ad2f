"""Answers of a solved scene: the block of eleven entries, its JSON, preload and lift-off, matrix files, the load curve."""

import csv
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import mmread
from tests.processes import COMMAND, ran

from rollbench.compare.commands.solve import dmig_text, matrix_market_text
from rollbench.compare.errors import InputError, SceneNotCoveredError
from rollbench.compare.models.answers import compute_scene_results, tangent_stiffness_at
from rollbench.compare.models.load_cases import SceneSolution
from rollbench.compare.models.loading import find_lift_off_load, preload_from_unloaded, solve_with_scaled_loads
from rollbench.compare.models.registry import MODELS, ModelOptions, run_model
from rollbench.compare.reference.estimate import reference_of_scene
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.results.compared import compare_models_with_reference
from rollbench.compare.results.scene_json import single_set_results_json
from rollbench.compare.scenes import catalogue, template
from rollbench.lowfi.rating.rigidity import approach_per_displacement
from rollbench.lowfi.statics import elastic, settle
from rollbench.meshes.parts import BallErrors, Errors

QUIET = ModelOptions(estimate_beam_mesh_error=False)


@pytest.fixture(scope="module")
def solved():
    scene = replace(catalogue.scene("lin-case3"), friction=None)
    result = run_model(scene, "lin", QUIET)
    return scene, result, compute_scene_results(scene, result, "lin", QUIET)


def test_the_json_holds_the_numbers_of_the_result(solved) -> None:
    scene, result, found = solved
    data = json.loads(json.dumps(single_set_results_json(SceneSolution(scene, result, found)), allow_nan=False))
    assert data["loads"]["max_N"] == pytest.approx(result.load.max())
    assert data["loads"]["mean_N"] == pytest.approx(result.load[result.load > 0].mean())
    assert data["axial"]["force_N"] == pytest.approx(5000.0)
    assert data["axial"]["rigidity_N_per_um"] == data["rigidities_N_per_um"]["with_unequal_loads"]
    # by pressure, which the screw's flank has more of at the same force
    assert data["worst_contact"]["side"].startswith("S")
    assert data["worst_contact"]["force_N"] == pytest.approx(data["loads"]["max_N"], rel=1e-3)
    assert data["friction"] is None
    assert "no coefficient" in data["friction_words"]
    alone, tangent = data["rigidities_N_per_um"]["contacts_alone"], data["axial"]["tangent_N_per_um"]
    assert 0.5 * alone < tangent < 1.5 * alone


def test_preload_is_what_the_flanks_press_without_load(solved) -> None:
    scene, _, found = solved
    bare = solve_with_scaled_loads(scene, 0.0, "lin", QUIET)
    held = preload_from_unloaded(scene, bare)
    assert (held, held.loaded) == (found.preload, 4 * scene.ball_count)
    assert held.axial == pytest.approx(approach_per_displacement(scene) * bare.load[:, 0].sum(), rel=0.02)


def test_the_first_contact_is_lost_where_lift_off_says(solved) -> None:
    scene, _, found = solved
    before, after = (solve_with_scaled_loads(scene, f * found.lift_off.factor, "lin", QUIET) for f in (0.98, 1.02))
    assert before.load.min() > 0.0
    assert after.load[found.lift_off.ball - 1, ["SL", "SR", "NL", "NR"].index(found.lift_off.side)] == 0.0
    assert found.lift_off.axial == pytest.approx(5000.0 * found.lift_off.factor)


def test_lift_off_below_the_scenes_load_and_without_preload() -> None:
    scene = replace(catalogue.scene("lin-case3"), errors=Errors(balls=BallErrors(oversize=2e-6)))
    result, bare = run_model(scene, "lin", QUIET), solve_with_scaled_loads(scene, 0.0, "lin", QUIET)
    found = find_lift_off_load(scene, result, bare, "lin", QUIET)
    assert 0.0 < found.factor < 1.0
    assert solve_with_scaled_loads(scene, 0.97 * found.factor, "lin", QUIET).load.min() > 0.0
    assert solve_with_scaled_loads(scene, 1.03 * found.factor, "lin", QUIET).load.min() == 0.0
    plain = catalogue.scene("lin-case1")
    assert find_lift_off_load(plain, result, solve_with_scaled_loads(plain, 0.0, "lin", QUIET), "lin", QUIET) is None


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


def test_a_model_without_bodies_has_no_tangent() -> None:
    with pytest.raises(InputError, match="mei"):
        tangent_stiffness_at(catalogue.scene("lin-case1"), 0.4, "mei", QUIET)


def test_curve_and_matrix_from_the_command_line(tmp_path: Path, command) -> None:
    curve, matrix = tmp_path / "curve.csv", tmp_path / "k.mtx"
    files = "--stiffness-at", "8 mm", "--matrix", matrix
    out = command.said("solve", "bearing-9", "--model", "lin", *files)
    assert "tangent stiffness" in out
    assert max(map(len, out.splitlines())) <= 100
    out = command.said("solve", "bearing-9", "--model", "lin", "--curve", "0:1.5:16", "--csv", curve)
    rows = list(csv.DictReader(curve.read_text().splitlines()))
    assert len(rows) == 16
    assert float(rows[10]["load_N"]) == pytest.approx(np.hypot(469.303395, 2963.065022))
    moved = [float(row["displacement_um"]) for row in rows]
    assert moved == sorted(moved)
    assert (tmp_path / "curve.svg").read_text().startswith("<?xml")
    assert mmread(matrix).shape == (6, 6)
    assert max(map(len, out.splitlines())) <= 100


PIPED = [("solve", "two-balls", "--model", "lin", "--balls"), ("friction", "two-balls", "--model", "lin", "--mu", "0.1")]


@pytest.mark.parametrize("words", PIPED)
def test_a_pipe_gets_plain_text_without_rules(words: tuple[str, ...]) -> None:
    """No box-drawing, no colours, no line wider than 100."""
    done = ran(*COMMAND, *words, environ={"FORCE_COLOR": ""})
    out = done.stdout
    assert done.returncode == 0, done.stderr
    assert not any(c in out for c in "┃│━─\x1b")
    assert max(map(len, out.splitlines())) <= 100


@pytest.mark.parametrize("model", ["lin", "source"])
def test_loads_are_answered_where_no_elastic_body_gives_a_tangent(monkeypatch, command, model) -> None:
    """A screw of more balls than elastic bodies take has loads and no tangent, and says why."""
    monkeypatch.setattr(elastic, "LARGEST", 20)
    words = "solve", "lin-case1", "--model", model
    axial = command.answer(*words)["summary"]["axial"]
    assert axial["tangent_N_per_um"] is None
    assert axial["tangent_words"].endswith("at most 20")
    assert "balls.count gives 32" in " ".join(command.said(*words).split())
    with pytest.raises(SceneNotCoveredError, match="at most 20"):
        tangent_stiffness_at(catalogue.scene("lin-case1"), 0.4, model, QUIET)


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


SOLVERS = [("lin-case3", "lin"), ("bearing-9", "refined"), ("double-nut", "lin"), ("double-nut", "refined")]


@pytest.mark.parametrize(("scene", "model"), SOLVERS)
def test_what_did_not_converge_prints_no_numbers_as_answers(monkeypatch, command, tmp_path, scene, model) -> None:
    if scene == "double-nut":
        scene = str(tmp_path / "two.toml")
        text = catalogue.shipped_scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.5")
        Path(scene).write_text(text, encoding="utf-8")
    whole = command.answer("solve", scene, "--model", model)
    monkeypatch.setattr(settle, "MAX_ITERATIONS", 1)
    code, data = command.json("solve", scene, "--model", model, "--json")
    assert (code, data["status"][:13]) == (1, "not converged")
    assert data.keys() == whole.keys()
    assert numbers(whole["balls"])
    assert not [key for key in ANSWERS if numbers(data.get(key))]
    code, text, _ = command("solve", scene, "--model", model, "--balls")
    assert code == 1
    assert not [line for line in text.splitlines() if re.search(r"\d\.\d+ (N|um)", line)]


def changed_40x10(folder: Path, *changes: tuple[str, str]) -> str:
    text = template.ball_screw_text("40x10")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    (folder / "my.toml").write_text(text, encoding="utf-8")
    return str(folder / "my.toml")


OUTSIDE = [
    ((), ()),
    ((('force = "5 % of C"', 'oversize = "60 um"'),), ("contact pressure", "static safety", "above C =")),
    (((', "5.7 kN"]', ', "900 kN"]'),), ("contact pressure", "below 1")),
    ((("conformity = 0.525  #", "conformity = 1.05  #"),), ("conformity above 0.6 (screw 1.05)",)),
    ((('"800 mm"\nfix = ["ux", "uy"]', '"800 mm"\nfix = ["ux"]\ndisplace = { uy = "40 mm" }'),), ("rotations of",)),
]


@pytest.mark.parametrize(("changes", "said"), OUTSIDE, ids=["as written", "oversize", "load", "conformity", "bent"])
def test_a_line_above_the_answers_says_what_leaves_the_models(tmp_path, command, changes, said) -> None:
    file = changed_40x10(tmp_path, *changes)
    lines = command.said("solve", file, "--model", "lin").splitlines()
    head = " ".join(lines[: next(k for k, line in enumerate(lines) if line.startswith("quantity "))])
    assert ("WARNING" in head) is bool(said)
    assert all(word in head for word in said), head
    assert sum("WARNING" in line for line in lines) == bool(said)
    code, data = command.json("solve", file, "--model", "lin", "--strict", "--json")
    assert (code, data["warning"] is not None) == (bool(said), bool(said))
    assert len(data["warnings"]) >= len(said)


@pytest.mark.parametrize(("conformity", "warned"), [("0.6", False), ("0.61", True)])
def test_a_groove_wider_than_any_is_warned_of(tmp_path: Path, command, conformity: str, warned: bool) -> None:
    file = changed_40x10(tmp_path, ("conformity = 0.525\n", f"conformity = {conformity}\n"))
    assert ("conformity above 0.6 (nut" in " ".join(command.said("solve", file, "--model", "lin").split())) is warned


def test_a_life_is_said_in_hours_and_kilometres_too(tmp_path: Path, command) -> None:
    """1200 rpm, lead 10 mm; several sets; a screw without a speed; a ring without a lead; a cycle at its mean speed."""
    moving = '[motion]\nspeed = "1200 rpm"\n'
    file = changed_40x10(tmp_path, ("[balls]\n", f"{moving}\n[balls]\n"))
    data = command.answer("solve", file, "--model", "lin")["summary"]["life"]
    revolutions = 1e6 * data["L10_million_revolutions"]
    assert (data["L10_hours"], data["L10_km"]) == pytest.approx((revolutions / 72_000.0, revolutions * 1e-5))
    lives = re.findall(r"^life L10 +[\d.]+  (.*?) ", command.said("solve", file, "--model", "lin"), re.MULTILINE)
    assert sorted(lives) == ["1e6", "h", "km"]
    sets = command.answer("solve", "double-nut", "--model", "lin")
    speed = catalogue.scene_of_any_kind("double-nut").motion.speed / (2.0 * np.pi)
    for life in (sets["summary"]["life"], *(one["summary"]["life"] for one in sets["sets"])):
        assert life["L10_hours"] == pytest.approx(1e6 * life["L10_million_revolutions"] / speed / 3600.0)
    file = changed_40x10(tmp_path)
    still = command.answer("solve", file, "--model", "lin")["summary"]["life"]
    assert ("L10_hours" in still, still["L10_km"] > 0.0) == (False, True)
    ring = command.answer("solve", "bearing-9", "--model", "lin")["summary"]["life"]
    assert ring["L10_km"] is None
    case = '[[cases]]\nname = "a"\ntime = "1 s"\nspeed = "600 rpm"\n'
    cycle = changed_40x10(tmp_path, ("# [friction]", f"{case}\n# [friction]"))
    life = command.answer("solve", cycle, "--model", "lin")["summary"]["life"]
    assert life["L10_hours"] == pytest.approx(1e6 * life["L10_million_revolutions"] / 36_000.0)
    assert re.search(r"life L10 +[\d.]+  km", command.said("solve", cycle, "--model", "lin"))


def test_several_sets_are_warned_of_by_name(tmp_path: Path, command) -> None:
    text = catalogue.shipped_scene_text("double-nut").replace('offset = "-4 um"', 'offset = "-120 um"')
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    code, out, _ = command("solve", tmp_path / "a.toml", "--model", "lin", "--strict")
    assert code == 1
    lines = out.splitlines()
    head = " ".join(lines[: next(k for k, line in enumerate(lines) if line.startswith("quantity "))])
    assert re.search("WARNING outside what the models mean: nut 1: .*nut 2: preload", head)


MODULI = [("210 MPa", 2), ("0.99 GPa", 2), ("1 GPa", 0), ("1001 GPa", 2), ("70 GPa", 0)]


@pytest.mark.parametrize(("modulus", "code"), MODULI)
def test_a_modulus_of_no_solid_is_refused_unless_it_is_meant(tmp_path: Path, command, modulus: str, code: int) -> None:
    material = f'youngs_modulus = "{modulus}"\npoissons_ratio = 0.3'
    rest = (('force = "5 % of C"', 'oversize = "0.1 um"'), (', "5.7 kN"]', ', "100 N"]'))
    file = changed_40x10(tmp_path, ('name = "bearing steel"', material), *rest)
    found, _, error = command("solve", file, "--model", "lin")
    assert found == code
    if code:
        assert re.search("material.youngs_modulus.*1 GPa to 1000 GPa", error)
        file = changed_40x10(tmp_path, ('name = "bearing steel"', f"unusual = true\n{material}"), *rest)
        assert command("solve", file, "--model", "lin").code == 0


def test_compare_counts_displacements_from_where_solve_does() -> None:
    scene = catalogue.scene("lin-case3")
    stores = (shipped_store(),)
    found = reference_of_scene(scene, stores)
    whole = compare_models_with_reference(scene, [MODELS["lin"]], found, stores)
    solved = compute_scene_results(scene, run_model(scene, "lin", QUIET), "lin", QUIET)
    (row,) = (b for b in whole.models if b.label == "lin")
    assert row.axial_displacement == pytest.approx(solved.displacement, rel=1e-9)
    assert whole.unloaded_position != 0.0
    bare = float(
        np.interp(
            scene.nut.position, whole.reference_loads.contact_loads.stations, whole.reference_loads.contact_loads.line[:, 2]
        )
    )
    assert whole.reference_loads.axial_displacement == pytest.approx(bare - whole.unloaded_position, rel=1e-12)
