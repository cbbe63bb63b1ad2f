"""Load cases of several sets on one shaft, and files whose columns case and set say which contacts a row is of."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from tests.unit.commands.test_solve_cases import run

import rollbench
from rollbench.comparison.reference.tasks import groups
from rollbench.comparison.scenes import scene_file
from rollbench.comparison.scenes.catalogue import scene_text
from rollbench.lowfi.rating.life import life, over_cases

PARTS = scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.0")
PARTS = PARTS.replace('length = "48 mm"', 'length = "30 mm"')
CASES = """
[[cases]]
name = "rapid"
share = 0.7
[[cases.loads]]
at = "0 mm"
force = ["0 N", "0 N", "300 N"]

[[cases]]
name = "cutting"
share = 0.3

[[cases]]
name = "warm"
share = 0
oversize = "1 um"
"""
NUTS, NAMES = ["nut 1", "nut 2"], ["rapid", "cutting", "warm"]


def written(folder: Path, text: str = PARTS + CASES, name: str = "dn.toml") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def told(capsys: pytest.CaptureFixture[str], *tokens: str) -> tuple[int, dict]:
    code = run(*tokens, "--json")
    return code, json.loads(capsys.readouterr().out)


def loads_of(folder: Path, path: str, **factors: float) -> str:
    """The loads of the model lin as a file, those of one case and set times a factor: ``cutting_2=0.8``."""
    file = folder / f"loads{len(factors)}.csv"
    assert run("solve", path, "--model", "lin", "--loads-csv", str(file)) == 0
    with file.open(encoding="utf-8") as read:
        rows = list(csv.DictReader(read))
    for row in rows:
        row["newton"] = repr(float(row["newton"]) * factors.get(f"{row['case']}_{row['set']}", 1.0))
    with file.open("w", encoding="utf-8") as out:
        writer = csv.DictWriter(out, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return str(file)


def test_every_case_is_the_scene_under_its_loads_and_every_set_has_its_life(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, found = told(capsys, "solve", written(tmp_path), "--model", "lin")
    assert code == 0
    assert [(one["scene"], one["case"], one["share"]) for one in found["cases"]] == [
        ("dn", name, share) for name, share in zip(NAMES, (0.7, 0.3, 0.0), strict=True)
    ]
    alone = told(capsys, "solve", written(tmp_path, PARTS, "alone.toml"), "--model", "lin")[1]
    assert found["cases"][1]["balls"] == alone["balls"]
    assert found["cases"][2]["balls"] != alone["balls"], "an oversize is that of every set"
    whole, parts = found["summary"], scene_file.read(PARTS, "dn.toml").sets
    each = [np.array([list(b["load_N"].values()) for b in one["balls"]]) for one in found["cases"]]
    for k, own in enumerate(whole["sets"]):
        loads = [load[8 * k : 8 * k + 8] for load in each]
        expected = life(parts[k].parts, over_cases(loads, [0.7, 0.3, 0.0]))
        assert own["name"] == NUTS[k]
        assert own["life"]["L10_million_revolutions"] == expected.revolutions
        assert own["standard_life"]["standard"] == "ISO 3408-5"
        assert abs(own["life_difference_percent"]) < 20.0, "the axial force of a nut is that of its contacts"
    shortest = min(whole["sets"], key=lambda own: own["life"]["L10_million_revolutions"])
    assert (whole["life"], whole["life_set"]) == (shortest["life"], shortest["name"])
    same = rollbench.solve(written(tmp_path), "lin")
    assert same["summary"] == whole
    assert same["cases"][2]["balls"] == found["cases"][2]["balls"]


def test_loads_on_housings_are_those_of_the_case() -> None:
    text = scene_text("axis-fixed-fixed") + '\n[[cases]]\nname = "a"\nshare = 1\n[[cases.housings]]\nname = "carriage"\n'
    cycle = scene_file.read(text + 'force = ["0 N", "0 N", "500 N"]\n', "a.toml")
    assert cycle.parts.housings[0].force == (0.0, 0.0, 3000.0)
    assert cycle.cases[0].scene.housings[0].force == (0.0, 0.0, 500.0)


def test_cases_share_their_bodies_and_loads_elsewhere_do_not() -> None:
    text = PARTS + CASES + '[[cases.loads]]\nat = "100 mm"\nforce = ["0 N", "0 N", "9 N"]\n'
    cases = [case.scene for case in scene_file.read(text, "dn.toml").cases]
    assert [[scene.name for scene in group] for group in groups(cases)] == [["dn-rapid", "dn-cutting"], ["dn-warm"]]


def test_one_reference_and_one_file_of_loads_are_read_by_case_and_set(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path)
    file, off = loads_of(tmp_path, path), loads_of(tmp_path, path, cutting_2=0.8)
    capsys.readouterr()
    code, found = told(capsys, "check", path, "--model", "lin", "--reference", file)
    assert (code, found["verdict"]) == (0, "pass")
    assert [(v["case"], v["set"]) for v in found["verdicts"]] == [(case, nut) for case in NAMES for nut in NUTS]
    code, found = told(capsys, "check", path, "--loads", off, "--reference", file)
    assert code == 1
    assert [(v["case"], v["set"]) for v in found["verdicts"] if v["word"] != "pass"] == [("cutting", "nut 2")]
    assert found["worst_cases"] == [{"scene": "dn", "case": "cutting", "verdict": "fail"}]
    assert rollbench.check(path, loads=off, reference=file).data["verdicts"] == found["verdicts"]
    code, found = told(capsys, "compare", path, "--model", "lin", "--reference", off)
    assert code == 0
    assert [(one["case"], one["set"]) for one in found["cases"]] == [(case, nut) for case in NAMES for nut in NUTS]
    assert [(row["set"], row["largest_error_case"]) for row in found["summary"]][1] == ("nut 2", "cutting")
    values = tmp_path / "values.csv"
    values.write_text("case,set,quantity,value,unit\ncutting,nut 2,life,1,revolutions\nrapid,1,rigidity,9,N/um\n")
    found = told(capsys, "check", path, "--values", str(values), "--reference", file)[1]
    assert [(v["case"], v["word"]) for v in found["verdicts"]] == [("rapid", "not covered"), ("cutting", "fail")]
    assert found["verdicts"][1]["set"] == "nut 2"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("case,set,", "case,note,"), "no rows of set 1 of case rapid"),
        (("warm,2,", "warm,3,"), "no rows of set 2 of case warm"),
        (("rapid,1,2,SL", "rapid,1,2,SR"), "each contact once"),
    ],
)
def test_rows_that_are_not_there_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], words: str
) -> None:
    path = written(tmp_path)
    file = Path(loads_of(tmp_path, path))
    file.write_text(file.read_text().replace(*change))
    capsys.readouterr()
    assert run("check", path, "--reference", str(file)) == 2
    said = capsys.readouterr().err
    assert (words in said, said.count("\n")) == (True, 1), said


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('[[cases.housings]]\nname = "table"\n', "cases[2].housings[0].name"),
        ('[[cases.loads]]\nat = "900 mm"\n', "cases[2].loads[0].at"),
        ('[[cases.supports]]\nat = "5 mm"\ndisplace = { ux = "1 um" }\n', "cases[2].supports[0].at"),
        ('[[cases]]\nname = "rapid"\nshare = 0\n', "cases[3].name"),
    ],
)
def test_what_a_case_of_several_sets_cannot_have_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str, words: str
) -> None:
    assert run("solve", written(tmp_path, PARTS + CASES + more)) == 2
    said = capsys.readouterr().err
    assert (words in said, said.count("\n")) == (True, 1), said


def test_friction_report_and_sweep(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = told(capsys, "friction", written(tmp_path), "--model", "lin")
    torques = [one["torque"]["friction_torque_Nmm"] for one in found["cases"]]
    assert code == 0
    assert found["summary"]["mean_friction_torque_Nmm"] == pytest.approx(0.7 * torques[0] + 0.3 * torques[1])
    assert run("report", written(tmp_path), "--out", str(tmp_path / "page")) == 2
    assert "one nut or ring" in capsys.readouterr().err
    vary = ["sets[0].offset=-4 um,-5 um"]
    swept = rollbench.sweep(written(tmp_path), vary, samples=2, method="grid", model="lin", out=tmp_path / "sweep")
    assert swept["converged"] == 2
