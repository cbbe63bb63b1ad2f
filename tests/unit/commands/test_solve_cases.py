"""``rollbench solve`` of a scene with load cases: list and summary, loads of all cases, a case that has no equilibrium."""

import csv

import numpy as np
import pytest
from tests.axes import one_set
from tests.helpers import small_screw
from tests.load_cases import CASES, SHIPPED, TEXT, case, written

import rollbench
from rollbench.compare.models.answers import parts_under_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.studies.sweep.keys import read_varied_keys
from rollbench.compare.studies.sweep.run import SweepDefinition
from rollbench.compare.studies.sweep.sample import VariedScene, solve_samples
from rollbench.lowfi.rating.life import basic_rating_life, damage_equivalent_loads, life_by_equivalent_loads

#: A ring that nothing holds across its two balls, without and with a force across them.
OPEN = case("held", share=0.5) + case("open", share=0.5) + 'loads = [{ at = "7 mm", force = ["0 N", "1 kN", "0 N"] }]\n'
NAMES = ["balls", "push", "loose"]


def solve(command, *words):
    return command.answer("solve", *words, "--model", "lin")


def test_cases_in_order_each_as_it_is_alone_and_their_summary(tmp_path, command) -> None:
    found = solve(command, written(tmp_path), "--loads-csv", tmp_path / "loads.csv")
    cases, whole, alone = found["cases"], found["summary"], solve(command, "two-balls")
    assert [(one["case"], one["share"]) for one in cases] == [*zip(NAMES, (0.75, 0.25, 0.0), strict=True)]
    assert cases[0]["balls"] == alone["balls"]
    assert (whole["largest_pressure_case"], whole["least_static_safety_case"]) == ("push", "push")
    assert whole["largest_pressure_MPa"] == max(one["summary"]["worst_contact"]["pressure_MPa"] for one in cases)
    loads = [solve_with_results(SHIPPED, "lin", ModelOptions()).loads]
    loads.append(np.array([list(ball["load_N"].values()) for ball in cases[1]["balls"]]))
    life = basic_rating_life(SHIPPED, damage_equivalent_loads(loads, [0.75, 0.25])).revolutions
    assert whole["reference_life"]["L10r_million_revolutions"] == life
    assert (whole["life"], "preload" in whole["life_words"]) == (None, True)
    rows = list(csv.DictReader((tmp_path / "loads.csv").read_text().splitlines()))
    assert list(rows[0])[:4] == ["case", "ball", "flank", "newton"]
    assert [row["case"] for row in rows[::8]] == NAMES
    one = solve(command, written(tmp_path, TEXT.replace(CASES, '\n[[cases]]\nname = "balls"\nshare = 1\n')))
    lives = [x["reference_life"] for x in (one["summary"], one["cases"][0]["summary"], alone["summary"])]
    assert lives[0] == lives[1] == lives[2], "to the last digit"


def test_a_case_without_equilibrium_ends_alone(tmp_path, command) -> None:
    text = TEXT.replace('fix = ["uy", "rx", "ry", "rz"]', 'fix = ["rx", "ry", "rz"]').replace(CASES, OPEN)
    code, found = command.json("solve", written(tmp_path, text), "--model", "lin", "--json")
    assert (code, [one["status"] == "converged" for one in found["cases"]]) == (1, [True, False])
    assert found["summary"]["life"] is None
    assert "case open" in found["summary"]["life_words"]
    assert "open" in found["status"]


def test_stiffness_curve_and_members_are_of_every_case(tmp_path, command) -> None:
    text = TEXT.replace("[errors.balls]\n", '[errors.balls]\nsigma = "0.1 um"\n', 1)
    path, csv_out = written(tmp_path, text), tmp_path / "members.csv"
    found = solve(command, path, "--stiffness-at", "7 mm", "--matrix", tmp_path / "k.mtx")
    first, pushed = (one["summary"]["stiffness"]["matrix"] for one in found["cases"][:2])
    assert first != pushed
    assert {file.name for file in tmp_path.glob("k-*.mtx")} == {f"k-{name}.mtx" for name in NAMES}
    members = solve(command, path, "--members", "2", "--csv", csv_out)
    assert [one["case"] for one in members["cases"]] == NAMES
    rows = [row.split(",")[:2] for row in csv_out.read_text().splitlines()]
    assert rows == [["case", "member"], *([name, str(k)] for name in NAMES for k in (0, 1))]


def test_friction_of_all_cases_and_its_mean_over_the_revolutions(tmp_path, command) -> None:
    found = command.answer("friction", written(tmp_path), "--model", "lin")
    torques = [one["torque"]["friction_torque_Nmm"] for one in found["cases"]]
    assert found["summary"]["mean_friction_torque_Nmm"] == pytest.approx(0.75 * torques[0] + 0.25 * torques[1])
    assert found["summary"]["largest_friction_torque_case"] == "push"
    assert [one["case"] for one in found["cases"]] == NAMES
    assert rollbench.friction(written(tmp_path), model="lin").cases["push"].torque == pytest.approx(1e-3 * torques[1])


def test_a_sweep_takes_the_worst_case_and_the_life_over_the_cycle(tmp_path) -> None:
    keys = read_varied_keys(["cases[1].supports[0].displace.uz=4 um,9 um"])
    SweepDefinition(TEXT, "two.toml", keys, 2, "grid", model="lin").check()
    low, high = solve_samples(VariedScene(TEXT, "two.toml", keys), [["4 um"], ["9 um"]], "lin")
    assert low["at"].startswith("case balls: ")
    assert high["at"].startswith("case push: ")
    pushed = rollbench.solve(written(tmp_path, TEXT.replace('uz = "8 um"', 'uz = "9 um"')), "lin")
    assert high["life_million_revolutions"] == pytest.approx(pushed.reference_life.revolutions, rel=1e-12)
    text = TEXT.replace(CASES, OPEN).replace('fix = ["uy", ', "fix = [")
    assert solve_samples(VariedScene(text, "two.toml", ()), [()], "lin")[0]["status"].startswith("case open: ")


@pytest.mark.parametrize("force", [0.02, 600.0])
def test_a_nut_on_a_shaft_bears_its_own_force_alone(force: float) -> None:
    """ISO 3408-5 adds preload between two halves: offsets that preload a set of several are in its force already."""
    screw = one_set(small_screw(4, force=(0.0, 0.0, force)))
    solved = solve_with_results(screw, "lin", ModelOptions())
    nut = solved.sets["nut"]
    found = life_by_equivalent_loads([parts_under_loads(screw, nut.parts)], [1.0], [-nut.force], nut.preload_of_halves)
    assert found.equivalent_loads == (pytest.approx(force, rel=1e-6), 0.0)
