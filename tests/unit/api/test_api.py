"""``import rollbench``: the commands' answers as records with units, and the module's own packages."""

import importlib
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.load_cases import written
from tests.processes import python
from tests.slow import all_slow_but

import rollbench
from rollbench.compare.gate import user
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes.catalogue import scene_names
from rollbench.compare.scenes.scene_file import parse_scene
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.parts import SIDES
from rollbench.reports.cells import with_typographic_signs


@pytest.fixture(scope="module")
def solved() -> rollbench.Result:
    return rollbench.solve("lin-case1", "lin")


def balls_of(data, key, size):
    return np.array([[np.nan if x is None else x for x in ball[key].values()] for ball in data["balls"]]).reshape(size, 4)


def test_fields_of_one_set_are_the_printed_numbers_in_si_units(solved: rollbench.Result, command) -> None:
    data = command.answer("solve", "lin-case1", "--model", "lin")
    summary = data["summary"]
    assert (solved.scene, solved.model, solved.status, solved.reason) == ("lin-case1", "lin", "converged", "")
    np.testing.assert_allclose(solved.loads, balls_of(data, "load_N", 32))
    np.testing.assert_allclose(np.degrees(solved.angles), balls_of(data, "contact_angle_deg", 32))
    np.testing.assert_allclose(1e3 * solved.z, [ball["z_mm"] for ball in data["balls"]])
    assert (solved.loads.shape, solved.displacement.shape, solved.stiffness.shape) == ((32, 4), (6,), (6, 6))
    worst = solved.worst
    assert 1e-6 * worst.pressure == pytest.approx(summary["worst_contact"]["pressure_MPa"])
    assert solved.pressure[worst.element - 1, ["SL", "SR", "NL", "NR"].index(worst.side)] == pytest.approx(worst.pressure)
    assert ((solved.pressure > 0.0) == (solved.loads > 0.0)).all()
    assert 1e6 * solved.displacement[2] == pytest.approx(summary["load_point"]["displacement_um"])
    assert 1e-6 * solved.nut.tangent == pytest.approx(summary["nut"]["tangent_N_per_um"])
    assert 1e-6 * solved.load_point.secant == pytest.approx(summary["load_point"]["secant_N_per_um"])
    assert pytest.approx(summary["life"]["L10_million_revolutions"]) == 1e-6 * solved.life.L10
    assert solved.expected_error.loads == data["model_form"]["largest_percent_of_mean"]
    said = solved.to_dict()
    matrix = said["summary"].pop("stiffness")["matrix"]  # the command computes it where `--stiffness-at` asks
    np.testing.assert_allclose(matrix, solved.stiffness)
    assert said | {"solver": None} == data | {"solver": None}


def test_the_matrix_is_symmetric_and_moves_with_its_section_and_the_tangents_do_not(solved: rollbench.Result) -> None:
    K = solved.stiffness
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    elsewhere = rollbench.solve("lin-case1", "lin", stiffness_at=0.3)
    assert (elsewhere.nut, elsewhere.load_point) == (solved.nut, solved.load_point)
    assert not np.allclose(elsewhere.stiffness, K, rtol=1e-3)


def test_the_stiffness_is_there_without_an_axial_force() -> None:
    scene = rollbench.read("lin-case3")  # preloaded
    found = rollbench.solve(replace(scene, loads=()), "lin")
    assert found.nut.tangent == pytest.approx(found.stiffness[2, 2], rel=0.05)
    assert found.nut.displacement is found.load_point.secant is None


WORST = [("lin-random", 2), ("unseen-40x10", 0), ("axis-fixed-fixed", 0)]


@pytest.mark.parametrize(("name", "member"), all_slow_but(WORST[:2], WORST))
def test_the_worst_contact_is_that_of_the_largest_pressure(name: str, member: int) -> None:
    found = rollbench.solve(name, "lin", member=member)
    for one in [*found.sets.values()] or [found]:
        i, s = np.unravel_index(one.pressure.argmax(), one.pressure.shape)
        worst = one.worst
        assert (worst.element, worst.side, worst.pressure) == (i + 1, SIDES[s], pytest.approx(one.pressure[i, s]))
        assert (worst.force, worst.angle) == (one.loads[i, s], one.angles[i, s])


def test_without_equilibrium_there_are_no_answers() -> None:
    scene = rollbench.read("lin-case1")
    lost = rollbench.solve(replace(scene, supports=()), "lin")
    assert (lost.status, "along the helix" in lost.reason) == (rollbench.Status.NOT_HELD, True)
    for name in ("loads", "angles", "pressure", "displacement", "stiffness", "life", "worst", "expected_error"):
        assert getattr(lost, name) is None, name
    assert lost.columns() == {}
    assert "loads: none" in repr(lost)
    with pytest.raises(ValueError, match="nothing to draw"):
        lost.plot()


def test_balls_are_rows_of_a_data_frame(solved: rollbench.Result, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    frame = solved.to_dataframe()
    assert frame.ball.tolist() == [*range(1, 33)]
    np.testing.assert_array_equal(frame[["load_SL_N", "pressure_NR_Pa"]].T, [solved.loads[:, 0], solved.pressure[:, 3]])
    assert frame.angle_SR_rad.isna().equals(frame.load_SR_N == 0.0)
    double = rollbench.solve("double-nut", "lin")
    of_sets = double.to_dataframe().groupby("set", sort=False).load_SL_N.max()
    assert of_sets.to_dict() == {name: one.loads[:, 0].max() for name, one in double.sets.items()}
    assert rollbench.solve(written(tmp_path), "lin").to_dataframe().case.unique().tolist() == ["balls", "push", "loose"]
    lost = rollbench.solve(replace(rollbench.read("lin-case1"), supports=()), "lin")
    assert lost.to_dataframe().empty


#: A program that holds the state of its process against that before it used the library.
STATE = """
import os, sys, random, numpy, rollbench
import matplotlib, logging, signal, warnings, scipy.linalg, scipy.special, scipy.sparse
from threadpoolctl import threadpool_info
def state():
    threads = [(x['filepath'], x['num_threads']) for x in threadpool_info()]
    drawn = random.getstate(), str(numpy.random.get_state())
    here = dict(os.environ), os.getcwd(), sys.path[:], signal.getsignal(signal.SIGTERM), warnings.filters[:]
    shown = numpy.geterr(), numpy.get_printoptions(), matplotlib.rcParams.copy()
    return threads, drawn, here, shown, logging.getLogger().handlers[:], logging.getLogger().level
before = state()
result = rollbench.solve('lin-case1', 'lin')
repr(result), str(result), result._repr_html_(), result.to_dict(), result.plot()
repr(rollbench.check('lin-case1', compute=False)), repr(rollbench.compare_models('lin-case1', ['lin']))
assert state() == before
"""


@pytest.mark.slow
def test_the_library_prints_nothing_and_changes_no_state() -> None:
    done = python("-c", STATE)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_values_have_units(solved: rollbench.Result) -> None:
    number = 1e6 * solved.displacement[2]
    assert solved.quantity("summary.load_point.displacement_um").to("mm").magnitude == pytest.approx(1e-3 * number)
    stiff = solved.quantity("summary.rigidities_N_per_um.contacts_alone")
    assert stiff.to("N/m").magnitude == pytest.approx(1e6 * stiff.magnitude)
    with pytest.raises(ValueError, match="no number with a unit"):
        solved.quantity("summary.loads.worst_ball")


def test_models_are_compared_with_a_stored_reference(tmp_path: Path) -> None:
    found = rollbench.compare_models("lin-case1", ["lin"], store=tmp_path)
    lin, exact = found.models["lin"], found.reference
    mean = exact.loads.sum() / 64.0
    assert found.errors["lin"] == lin.largest_error == pytest.approx(6.15, abs=0.1)
    np.testing.assert_allclose(lin.errors, 100.0 * (lin.loads - exact.loads) / mean, atol=1e-9)
    assert np.abs(lin.errors).max() == pytest.approx(lin.largest_error)
    assert np.abs(lin.errors)[lin.ball - 1, SIDES.index(lin.side)] == pytest.approx(lin.largest_error)
    assert found.seconds["lin"] > 0.0
    assert found.uncertainties.shape == exact.loads.shape == (32, 4)
    assert 0.0 < found.uncertainty.discretisation < found.uncertainty.total < lin.largest_error
    data = found.to_dict()
    assert data["models"]["lin"]["largest_error_percent"] == lin.largest_error
    assert data["answers"]["3D reference"]["worst_contact"]["pressure_MPa"] == pytest.approx(1e-6 * exact.pressure)


def test_a_verdict_has_typed_rows(tmp_path: Path, command) -> None:
    judged = rollbench.check("lin-case1", max_error=1e-3, limits={"angle": 1}, compute=False, store=tmp_path)
    words = "check", "lin-case1", "--max-error", "1e-3", "--limit", "angle=1", "--no-compute", "--store", str(tmp_path)
    code, data = command.json(*words, "--json")
    assert (judged.passed, judged.judgement, code) == (False, rollbench.Judgement.FAIL, 1)
    assert judged.to_dict() == data
    first, angle = judged.rows[0], judged.rows[1]
    assert judged.worst == first
    printed, of_angle = data["verdicts"][:2]
    assert (first.error, first.uncertainty) == (printed["error_percent"], printed["uncertainty_percent"])
    assert (first.ball, angle.unit, angle.error) == (printed["ball"], "deg", of_angle["error_deg"])
    assert repr(judged).startswith("verdict: fail")


@pytest.mark.parametrize(
    ("factor", "max_error", "word"),
    [(1.0, 7.0, "pass"), (1.0, 0.4, "undecided"), (1.0, 1e-3, "fail"), (1.1, 7.0, "not covered")],
)
def test_an_answer_with_a_verdict_is_true_if_it_passed(factor: float, max_error: float, word: str, tmp_path: Path) -> None:
    scene = rollbench.read("two-balls")
    scene = replace(scene, track=replace(scene.track, pitch_radius=factor * scene.track.pitch_radius))
    judged = rollbench.check(scene, max_error=max_error, compute=False, store=tmp_path)
    (row,) = judged.rows
    answers = judged, row, judged.judgement, row.judgement
    assert (judged.word, [bool(one) for one in answers]) == (word, [word == "pass"] * len(answers))


def test_a_model_outside_its_validity_is_said_to_be_and_fails_if_strict(tmp_path: Path, monkeypatch) -> None:
    """Whatever its loads are: the same kinds of warnings as under ``solve --strict``; a remark changes nothing."""
    for warned, word in (
        (ResultWarning("tilt", "it tilts: ...", "it tilts"), "fail"),
        (ResultWarning("edge", "cut"), "pass"),
    ):
        with_warning = replace(run_model(rollbench.read("two-balls"), "lin"), warnings=(warned,))
        monkeypatch.setattr(user, "run_model", lambda *_, result=with_warning: result)
        given = {"model": "lin", "max_error": 50.0, "compute": False, "store": tmp_path}
        loose, strict = (rollbench.check("two-balls", strict=strict, **given) for strict in (False, True))
        assert (loose.word, strict.word) == ("pass", word)
        assert ("outside what the models mean: it tilts" in loose.rows[0].detail) is (word == "fail")


@pytest.mark.parametrize("name", scene_names())
def test_scenes_are_equal_if_their_contents_are(name: str) -> None:
    scene = rollbench.read(name)
    again = parse_scene(scene.to_toml(), name) if hasattr(scene, "to_toml") else pickle.loads(pickle.dumps(scene))
    assert (scene == again, hash(scene) == hash(again)) == (True, True)
    assert scene not in (replace(scene, title="another"), name, None)


def test_records_with_arrays_differ_by_one_element() -> None:
    pair = rollbench.read("lin-pair-a")
    assert pair != replace(pair, side=np.add(pair.side, [0.0, 1e-9]))
    answers = [rollbench.ModelAnswer(np.full((2, 4), load)) for load in (1.0, 1.0, 2.0)]
    assert (answers[0] == answers[1], answers[0] == answers[2], len({*answers})) == (True, False, 2)
    assert answers[0] != rollbench.ModelAnswer(np.ones((2, 4)), np.zeros(6))


def test_an_ensemble_has_typed_statistics(command) -> None:
    found = rollbench.ensemble("lin-random", 3, "lin")
    data = command.answer("solve", "lin-random", "--members", "3", "--model", "lin")
    assert (found.members, found.converged, found.failed) == (3, 3, {})
    each = [rollbench.solve("lin-random", "lin", member=k).loads.max() for k in range(3)]
    largest = found.outputs["largest_load_N"]
    assert (largest.mean, largest.largest) == (pytest.approx(np.mean(each)), pytest.approx(max(each)))
    assert largest.quantiles[0.5] == pytest.approx(np.median(each))
    assert found.to_dict()["statistics"] == data["statistics"]


@pytest.mark.slow
def test_the_page_of_a_scene_is_written(tmp_path: Path) -> None:
    page = rollbench.report("two-balls", out=tmp_path / "page", store=tmp_path)
    assert page.passed
    assert with_typographic_signs(page.verdict) in page.page.read_text(encoding="utf-8")


def test_the_former_function_names_its_successor():
    assert importlib.import_module("rollbench.compare") is rollbench.compare
    with pytest.raises(TypeError, match="compare_models"):
        rollbench.compare("lin-case1")
