"""Load cases of several sets on one shaft, and files whose columns case and set say which contacts a row is of."""

import csv
from pathlib import Path

import numpy as np
import pytest
from tests.load_cases import case

import rollbench
from rollbench.compare.reference.tasks import group_scenes_by_geometry
from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.lowfi.rating.life import basic_rating_life, damage_equivalent_contact_loads

PARTS = shipped_scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.0")
PARTS = PARTS.replace('length = "48 mm"', 'length = "30 mm"')
CASES = case("rapid", "300 N", share=0.7) + case("cutting", share=0.3) + case("warm", share=0, oversize="1 um")
NUTS, NAMES = ["nut 1", "nut 2"], ["rapid", "cutting", "warm"]


def written(folder: Path, text: str = PARTS + CASES, name: str = "dn.toml") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def loads_of(command, folder: Path, path: str, **factors: float) -> str:
    """The loads of the model lin as a file, those of one case and set times a factor: ``cutting_2=0.8``."""
    file = folder / f"loads{len(factors)}.csv"
    assert command("solve", path, "--model", "lin", "--loads-csv", file).code == 0
    with file.open(encoding="utf-8") as read:
        rows = list(csv.DictReader(read))
    for row in rows:
        row["newton"] = repr(float(row["newton"]) * factors.get(f"{row['case']}_{row['set']}", 1.0))
    with file.open("w", encoding="utf-8") as out:
        writer = csv.DictWriter(out, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return str(file)


def test_every_case_is_the_scene_under_its_loads_and_every_set_has_its_life(command, tmp_path: Path) -> None:
    found = command.answer("solve", written(tmp_path), "--model", "lin")
    shares = [("dn", name, share) for name, share in zip(NAMES, (0.7, 0.3, 0.0), strict=True)]
    assert [(one["scene"], one["case"], one["share"]) for one in found["cases"]] == shares
    alone = command.answer("solve", written(tmp_path, PARTS, "alone.toml"), "--model", "lin")
    assert found["cases"][1]["balls"] == alone["balls"]
    assert found["cases"][2]["balls"] != alone["balls"], "an oversize is that of every set"
    whole, parts = found["summary"], scene_file.parse_scene(PARTS, "dn.toml").sets
    each = [np.array([list(b["load_N"].values()) for b in one["balls"]]) for one in found["cases"]]
    for k, of_set in enumerate(whole["sets"]):
        loads = [load[8 * k : 8 * k + 8] for load in each]
        expected = basic_rating_life(parts[k].parts, damage_equivalent_contact_loads(loads, [0.7, 0.3, 0.0]))
        assert (of_set["name"], of_set["standard_life"]["standard"]) == (NUTS[k], "ISO 3408-5")
        assert of_set["life"]["L10_million_revolutions"] == expected.revolutions
        assert abs(of_set["life_difference_percent"]) < 20.0, "the axial force of a nut is that of its contacts"
    shortest = min(whole["sets"], key=lambda of_set: of_set["life"]["L10_million_revolutions"])
    assert (whole["life"], whole["life_set"]) == (shortest["life"], shortest["name"])
    same = rollbench.solve(written(tmp_path), "lin").to_dict()
    assert same["summary"] == whole
    assert same["cases"][2]["balls"] == found["cases"][2]["balls"]


def test_loads_on_housings_are_those_of_the_case_and_cases_share_their_bodies_but_for_loads_elsewhere() -> None:
    text = (
        shipped_scene_text("axis-fixed-fixed")
        + '\n[[cases]]\nname = "a"\nshare = 1\n[[cases.housings]]\nname = "carriage"\n'
    )
    cycle = scene_file.parse_scene(text + 'force = ["0 N", "0 N", "500 N"]\n', "a.toml")
    forces = [scene.housings[0].force[2] for scene in (cycle.parts, cycle.cases[0].scene)]
    assert forces == [3000.0, 500.0]
    text = PARTS + CASES + '[[cases.loads]]\nat = "100 mm"\nforce = ["0 N", "0 N", "9 N"]\n'
    cases = [one.scene for one in scene_file.parse_scene(text, "dn.toml").cases]
    assert [[scene.name for scene in group] for group in group_scenes_by_geometry(cases)] == [
        ["dn-rapid", "dn-cutting"],
        ["dn-warm"],
    ]


def test_one_reference_and_one_file_of_loads_are_read_by_case_and_set(command, tmp_path: Path) -> None:
    path = written(tmp_path)
    file, off = loads_of(command, tmp_path, path), loads_of(command, tmp_path, path, cutting_2=0.8)
    each = [(name, nut) for name in NAMES for nut in NUTS]
    code, found = command.json("check", path, "--model", "lin", "--reference", file, "--json")
    assert (code, found["verdict"]) == (0, "pass")
    assert [(v["case"], v["set"]) for v in found["verdicts"]] == each
    code, found = command.json("check", path, "--loads", off, "--reference", file, "--json")
    assert code == 1
    assert [(v["case"], v["set"]) for v in found["verdicts"] if v["word"] != "pass"] == [("cutting", "nut 2")]
    assert found["worst_cases"] == [{"scene": "dn", "case": "cutting", "verdict": "fail"}]
    assert rollbench.check(path, loads=off, reference=file).to_dict()["verdicts"] == found["verdicts"]
    code, found = command.json("compare", path, "--model", "lin", "--reference", off, "--json")
    assert (code, [(one["case"], one["set"]) for one in found["cases"]]) == (0, each)
    assert [(row["set"], row["largest_error_case"]) for row in found["summary"]][1] == ("nut 2", "cutting")
    values = tmp_path / "values.csv"
    values.write_text("case,set,quantity,value,unit\ncutting,nut 2,life,1,revolutions\nrapid,1,rigidity,9,N/um\n")
    found = command.json("check", path, "--values", values, "--reference", file, "--json")[1]
    words = [(v["case"], v.get("set"), v["word"]) for v in found["verdicts"]]
    assert words == [("rapid", None, "not covered"), ("cutting", "nut 2", "fail")]


MISSING = [
    (("case,set,", "case,note,"), "no rows of set 1 of case rapid"),
    (("warm,2,", "warm,3,"), "no rows of set 2 of case warm"),
    (("rapid,1,2,SL", "rapid,1,2,SR"), "each contact once"),
]


@pytest.mark.parametrize(("change", "words"), MISSING)
def test_rows_that_are_not_there_are_one_line(command, tmp_path: Path, change: tuple[str, str], words: str) -> None:
    path = written(tmp_path)
    file = Path(loads_of(command, tmp_path, path))
    file.write_text(file.read_text().replace(*change))
    assert words in command.refused("check", path, "--reference", file)


REFUSED = [
    ('[[cases.housings]]\nname = "table"\n', "cases[2].housings[0].name"),
    ('[[cases.loads]]\nat = "900 mm"\n', "cases[2].loads[0].at"),
    ('[[cases.supports]]\nat = "5 mm"\ndisplace = { ux = "1 um" }\n', "cases[2].supports[0].at"),
    ('[[cases]]\nname = "rapid"\nshare = 0\n', "cases[3].name"),
]


@pytest.mark.parametrize(("table", "words"), REFUSED)
def test_what_a_case_of_several_sets_cannot_have_is_one_line(command, tmp_path: Path, table: str, words: str) -> None:
    assert words in command.refused("solve", written(tmp_path, PARTS + CASES + table))


def test_friction_report_and_sweep(command, tmp_path: Path) -> None:
    found = command.answer("friction", written(tmp_path), "--model", "lin")
    torques = [one["torque"]["friction_torque_Nmm"] for one in found["cases"]]
    assert found["summary"]["mean_friction_torque_Nmm"] == pytest.approx(0.7 * torques[0] + 0.3 * torques[1])
    vary = ["sets[0].offset=-4 um,-5 um"]
    swept = rollbench.sweep(written(tmp_path), vary, samples=2, method="grid", model="lin", out=tmp_path / "sweep")
    assert swept.converged == 2
