"""Drawn catalogue screws on the 3D reference: the drawing, an interrupted survey, two small ones; all with -m survey."""

import json
from pathlib import Path

import numpy as np
import pytest

from rollbench.compare.commands.survey import solve_drawn_screws
from rollbench.compare.errors import InputError
from rollbench.compare.models import many
from rollbench.compare.reference.tasks import flanks_to_mesh, mesh_settings
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import survey
from rollbench.compare.studies.survey import SCENES, SEED, random_screw_scene_text, screw_properties_for_record
from rollbench.hifi.meshing.part_meshes import choose_refinement_box_size
from rollbench.hifi.meshing.settings import estimate_contacts_of_scene
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene
from rollbench.meshes.record_keys import digest_of_values
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Two of the fewest contacts: without preload, and with clearance, which takes three times as long.
SMALL = (69, 136)


def drawn(number: int) -> Scene:
    return scene_file.scene_from_text(random_screw_scene_text(SEED, number), "survey.toml")


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the screws that a survey solves, each with an answer at once but the first, which is refused."""
    done: list[int] = []

    def answered(_: int, number: int, __: Path, ___: str) -> dict[str, object]:
        done.append(number)
        status = "converged" if number else "refused"
        return {"number": number, "version": survey.__version__, "status": status, "seconds": 1.0}

    monkeypatch.setattr(survey, "survey_screw", answered)
    return done


def test_the_drawing_is_the_same_for_ever_and_can_be_read() -> None:
    assert digest_of_values(*map(drawn, range(10)))[:12] == "ba9df4b3ee07"
    found = [screw_properties_for_record(drawn(number)) for number in range(10)]
    ends = np.array([[r["low_face_radii"], r["high_face_radii"]] for r in found])
    assert ((ends > 1.0) & (ends < 6.1)).all()
    assert {r["starts"] for r in found} == {1, 2}
    assert {r["hand"] for r in found} == {"left", "right"}


@pytest.mark.parametrize("number", [38, 54])
def test_a_flank_that_may_touch_has_its_opposite_prepared(number: int) -> None:
    """Three flanks are expected to touch: bodies are condensed to pairs of opposite ones."""
    scene = drawn(number)
    sides = flanks_to_mesh(scene)
    assert len(estimate_contacts_of_scene(scene).nearly_touching_flanks()) == 3
    assert {3 - side for side in sides} == set(sides)


@pytest.mark.parametrize("number", [2, 6, 66, 89, 130, 154, 194])
def test_balls_at_the_face_find_room_for_their_sockets(number: int) -> None:
    """Outermost balls 1.00 to 1.13 ball radii from a face: a lip of a tenth of a millimetre beside some contacts."""
    scene = drawn(number)
    assert 1.0 <= screw_properties_for_record(scene)["low_face_radii"] < 1.14
    settings = mesh_settings([scene], 1)
    m, dimensions = GrooveMap.from_scene(scene), dimensions_of_3d_parts(scene)
    size = choose_refinement_box_size(scene, m, ball_layout(scene), flanks_to_mesh(scene), dimensions, settings)
    assert size.gamma * m.radius.min() >= settings.reach[0]
    assert size.phi * m.R >= settings.reach[1]


def test_an_interrupted_survey_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, solved: list[int]) -> None:
    answered, said = survey.survey_screw, list[str]()

    def interrupted(seed: int, number: int, folder: Path, kind: str) -> dict[str, object]:
        if number == 2 and not any("1 stored" in line for line in said):
            raise KeyboardInterrupt
        return answered(seed, number, folder, kind)

    monkeypatch.setattr(survey, "survey_screw", interrupted)
    with pytest.raises(KeyboardInterrupt):
        survey.solve_screws_of_survey(SEED, 3, tmp_path / "out", 1, said.append)
    with next((tmp_path / "out" / many.RECORDS).glob("*.lines")).open("ab") as file:
        file.write(b"12345678 torn")
    solved.clear()
    records = survey.solve_screws_of_survey(SEED, 3, tmp_path / "out", 1, said.append)
    assert solved == [0, 2]  # what had no answer is tried again
    assert [r["number"] for r in records] == [0, 1, 2]
    assert [r["number"] for r in survey.records_without_converged_loads(records)] == [0]
    assert "[1/3] scene 0: refused, 1 s" in said
    assert json.loads(survey.survey_records_as_json(SEED, records))["scenes"] == records
    with pytest.raises(InputError, match="another computation"):
        survey.solve_screws_of_survey(SEED + 1, 3, tmp_path / "out", 1, said.append)


def test_a_kept_record_is_not_solved_again(tmp_path: Path, solved: list[int]) -> None:
    """Of this version, and with an answer."""
    kept = tmp_path / "survey.json"
    for version, numbers in ((survey.__version__, [1, 2]), ("0.1", [0, 1, 2])):
        rows = [{"number": k, "version": version, "status": s} for k, s in enumerate(("converged", "refused"))]
        kept.write_text(survey.survey_records_as_json(SEED, rows))
        solved.clear()
        records = survey.solve_screws_of_survey(SEED, 3, tmp_path / version, 1, lambda _: None, kept)
        assert solved == numbers
        assert (records[0] == rows[0]) is (0 not in numbers)


def test_the_summary_counts_sizes_of_errors_with_an_answer() -> None:
    def row(status: str, error: float) -> dict[str, object]:
        return {"number": 0, "status": status, "models": {"refined": {"largest_percent": error, "rigidity_percent": None}}}

    rows = [row("converged", -1.0), row("converged", 3.0), row("not settled", 9.0)]
    (found,) = survey.error_summary_rows_of_all_models(rows)
    assert (found["model"], found["error"], found["scenes"], found["median"]) == ("refined", "largest_percent", 2, 2.0)
    assert (found["p95"], found["largest"]) == (pytest.approx(2.9), 3.0)
    assert len(found) == 6


def test_the_command_prints_what_has_no_answer_and_keeps_the_record(tmp_path, monkeypatch) -> None:
    records = [{"number": 0, "status": "converged"}, {"number": 1, "status": "not settled: 1 N"}]
    monkeypatch.setattr(survey, "solve_screws_of_survey", lambda *_: records)
    keep = tmp_path / "survey.json"
    found = solve_drawn_screws(2, tmp_path, 1, keep)
    assert found.exit_code == 1
    assert list(found.texts_and_tables)[-2:] == ["1 of 2 scenes have a result", "scene 1: not settled: 1 N"]
    assert json.loads(keep.read_text())["scenes"] == records
    with pytest.raises(InputError, match="survey: "):
        solve_drawn_screws(SCENES + 1, tmp_path, 1, None)


NUMBERS = [pytest.param(k, marks=() if k in SMALL else pytest.mark.survey) for k in range(SCENES)]


@pytest.mark.slow
@pytest.mark.parametrize("number", NUMBERS)
def test_every_drawn_screw_has_an_answer(number: int) -> None:
    record = survey.survey_screw(SEED, number)
    assert (record["status"], record["raised_status"]) == ("converged", "converged")
    assert record["models"]["refined"]["largest_percent"] < 15.0
