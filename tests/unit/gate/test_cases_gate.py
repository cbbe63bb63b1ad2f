"""check and compare of a scene with load cases: every case beside its own reference, the worst one named."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from tests.load_cases import SHIPPED, written
from tests.load_cases import TEXT as WITH_STORED

import rollbench
from rollbench.compare.gate import user
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.reference.store import load_stored_run, save_run
from rollbench.compare.reference.tasks import group_scenes_by_geometry, mesh_settings, mesh_settings_with_tuples
from rollbench.compare.scenes import scene_file
from rollbench.lowfi.rating.life import basic_rating_life, damage_equivalent_contact_loads

#: No case has a shipped run: the balls are larger by 0.1 um than those of the shipped scene.
TEXT = WITH_STORED.replace('name = "balls"', 'name = "rest"').replace('oversize = "5 um"', 'oversize = "5.1 um"')


def keep(store, text: str, **off: float) -> dict[str, np.ndarray]:
    """Store runs as if the 3D reference had found the loads of the model lin, but for a factor on those of some cases."""
    store.mkdir()
    shipped, out = load_stored_run(SHIPPED, 1), {}
    for case in scene_file.parse_scene(text, "two.toml").cases:
        settings = mesh_settings_with_tuples(asdict(mesh_settings([case.scene], 1, "")))
        found = run_model(case.scene, "lin", ModelOptions(estimate_beam_mesh_error=False)).load * off.get(case.name, 1.0)
        save_run(store, case.scene, replace(shipped, scene=case.scene.name, load=found, settings=settings))
        out[case.name] = found
    return out


def checked(command, store, path: str, *words: object) -> tuple[int, dict]:
    return command.json("check", path, "--model", "lin", "--stored", store, "--json", *words)


def verdicts(found: dict) -> dict[str, str]:
    return {one["case"]: one["verdict"] for one in found["cases"]}


def test_the_gate_takes_the_worst_case_and_names_it(command, tmp_path) -> None:
    cases = [case.scene for case in scene_file.parse_scene(TEXT, "two.toml").cases]
    assert [[scene.name for scene in group] for group in group_scenes_by_geometry(cases)] == [
        ["two-rest", "two-push", "two-loose"]
    ]
    keep(tmp_path / "store", TEXT, push=0.7)
    code, found = checked(command, tmp_path / "store", written(tmp_path, TEXT), "--junit", tmp_path / "out.xml")
    assert verdicts(found) == {"rest": "pass", "push": "fail", "loose": "pass"}
    assert (code, found["verdict"], found["passed"]) == (1, "fail", False)
    assert found["worst_cases"] == [{"scene": "two", "case": "push", "verdict": "fail"}]
    assert found["verdicts"] == [v for one in found["cases"] for v in one["verdicts"]]
    assert "two, case push" in (tmp_path / "out.xml").read_text()
    same = rollbench.check(written(tmp_path, TEXT), model="lin", store=tmp_path / "store", compute=False)
    assert same.to_dict()["worst_cases"] == found["worst_cases"]


def test_what_does_not_converge_comes_after_what_fails_and_before_what_is_undecided(command, tmp_path, monkeypatch) -> None:
    keep(tmp_path / "store", TEXT, loose=1.07)
    solve = user.run_model

    def lost(scene, *rest):
        found = solve(scene, *rest)
        return replace(found, status="not converged") if scene.name == "two-push" else found

    monkeypatch.setattr(user, "run_model", lost)
    code, found = checked(command, tmp_path / "store", written(tmp_path, TEXT), "--max-error", "7")
    assert verdicts(found) == {"rest": "pass", "push": "not converged", "loose": "undecided"}
    assert (code, found["worst_cases"][0]["case"]) == (1, "push")


def test_a_case_without_reference_is_not_covered(command, tmp_path) -> None:
    (tmp_path / "none").mkdir()
    code, found = checked(command, tmp_path / "none", written(tmp_path, TEXT))
    assert (code, verdicts(found)) == (4, dict.fromkeys(("rest", "push", "loose"), "not covered"))


def test_compare_sets_the_life_over_the_cycle_beside_that_of_the_reference(command, tmp_path) -> None:
    loads = keep(tmp_path / "store", TEXT, push=0.9)
    words = "compare", written(tmp_path, TEXT), "--model", "lin", "--store", tmp_path / "store", "--json"
    code, found = command.json(*words)
    assert (code, found["scenes"]) == (0, [])
    shares = {("two", "rest"): 0.75, ("two", "push"): 0.25, ("two", "loose"): 0.0}
    assert {(one["scene"], one["case"]): one["share"] for one in found["cases"]} == shares
    (whole,) = found["summary"]
    assert whole["largest_error_case"] == "push"
    by_reference = basic_rating_life(SHIPPED, damage_equivalent_contact_loads([loads["rest"], loads["push"]], [0.75, 0.25]))
    assert whole["life_million_revolutions"]["3D reference"] == pytest.approx(by_reference.revolutions, rel=1e-6)
    assert whole["life_error_percent"] < -1.0
    assert {row["case"] for row in found["rows"]} == {"rest", "push", "loose"}
    same = rollbench.compare_models(written(tmp_path, TEXT), ["lin"], store=tmp_path / "store").to_dict()
    assert same["summary"] == whole
    assert [one["case"] for one in same["cases"]] == ["rest", "push", "loose"]


def test_a_file_of_loads_is_judged_case_by_case(command, tmp_path) -> None:
    keep(tmp_path / "store", TEXT, loose=0.5)
    path, loads = written(tmp_path, TEXT), tmp_path / "loads.csv"
    assert command("solve", path, "--model", "lin", "--loads-csv", loads).code == 0
    words = ("check", path, "--loads", loads, "--stored", tmp_path / "store", "--json")
    code, found = command.json(*words)
    assert (code, verdicts(found)) == (1, {"rest": "pass", "push": "pass", "loose": "fail"})
    assert found["worst_cases"][0]["case"] == "loose"
    kept = [row for row in loads.read_text().splitlines() if not row.startswith("push")]
    loads.write_text("\n".join(kept) + "\n")
    assert "no rows of case push" in command.refused(*words), "a case whose rows are missing is not passed over"


@pytest.mark.slow
def test_one_file_with_three_cases_goes_through_all_commands_with_one_set_of_bodies(command, tmp_path, monkeypatch) -> None:
    from rollbench.hifi import setup

    path, store, set_ups, prepare = written(tmp_path, TEXT), str(tmp_path / "store"), [], setup.mesh_and_condense_geometry
    monkeypatch.setattr(
        setup, "mesh_and_condense_geometry", lambda *given, **options: set_ups.append(1) or prepare(*given, **options)
    )
    limits = "--limit", "life=50", "--limit", "contact angle=5"
    commands = {"solve": (), "compare": ("--levels", "1", "--store", store), "check": ("--stored", store, *limits)}
    for word, options in (commands | {"friction": ()}).items():
        model = () if word == "compare" else ("--model", "lin")
        _, found = command.json(word, path, *model, *options, "--json")
        assert list(dict.fromkeys(one["case"] for one in found["cases"])) == ["rest", "push", "loose"], word
        assert "summary" in found or found["worst_cases"], word
    assert "Of 3 load cases" in command.said("report", path, "--out", tmp_path / "page", "--store", store)
    assert len(set_ups) == 1
