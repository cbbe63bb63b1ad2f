"""Tables of stiffness over a scene's keys, their files, and a rotor of ROSS on two of their rows."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

import rollbench
from rollbench.compare.cli import main
from rollbench.compare.studies.table_files import write_table
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics import elastic
from rollbench.meshes.parts import FREEDOMS, Support

#: An interpreter that has ROSS, if not this one.
ROSS = os.environ.get("ROSS_PYTHON", sys.executable)
ROTOR = """
import numpy as np, ross, bearings
steel = ross.Material("steel", rho=7810, E=211e9, G_s=81.2e9)
shaft = [ross.ShaftElement(L=0.1, idl=0, odl=0.04, material=steel) for _ in range(8)]
free = [ross.BearingElement(n=n, kxx=0.0, cxx=0.0) for n in (2, 6)]
rotors = [ross.Rotor(shaft, [], b) for b in ([bearings.bearing(2, 0), bearings.bearing(6, 1)], free)]
for rotor in rotors:
    square = np.linalg.eigvals(np.linalg.solve(rotor.M(), rotor.K(0))).real
    print("hertz", *np.sqrt(np.sort(square).clip(0.0)) / 2.0 / np.pi)
print("added", *(rotors[0].K(0) - rotors[1].K(0))[12:15, 12:15].ravel())
"""


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as stopped:
        main([str(x) for x in arguments])
    return int(stopped.value.code or 0), *capsys.readouterr()


def test_stiffness_of_a_row_against_finite_differences_of_the_solution(tmp_path):
    motion = np.array([2e-6, -1e-6, 3e-6, 2e-5, -1e-5, 0.0])
    scene = small_screw(4, oversize=4e-6)
    station = scene.nut.position

    def held(at):
        return replace(scene, supports=(Support(station, tuple(zip(FREEDOMS, map(float, at), strict=True))),), loads=())

    def reaction(at):
        balance = elastic.solve_elastic(held(at), backend=LADDER["refined"]).equilibrium
        force = balance.reaction_force
        return np.concatenate([force, balance.reaction_moment - np.cross([0.0, 0.0, station], force)])

    file = tmp_path / "held.toml"
    file.write_text(held(motion).to_toml())
    (row,) = rollbench.table(file, quantities=["stiffness"]).rows
    steps = np.diag([1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6])
    measured = np.array([(reaction(motion + h) - reaction(motion - h)) / (2.0 * h.max()) for h in steps]).T
    size = np.sqrt(np.diag(measured))
    assert np.abs((row.stiffness - measured) / np.outer(size, size)).max() < 1e-4


def test_a_nut_beyond_the_thread_is_a_row_with_its_reason_and_the_table_goes_to_ross_and_modelica(tmp_path, capsys):
    over = ("--over", "nut.position=100:900:3", "mm", "--over", "load=1:10:2", "kN", "--quantities", "stiffness,pressure")
    code, _, _ = run(capsys, "table", "lin-case3", *over, "--out", tmp_path / "t.json")
    assert code == 0
    data = json.loads((tmp_path / "t.json").read_text())
    assert [row["nut.position_mm"] for row in data["rows"]] == [100.0, 100.0, 500.0, 500.0, 900.0, 900.0]
    assert [row["status"] == "converged" for row in data["rows"]] == [True] * 4 + [False] * 2
    assert "must lie on the screw" in data["rows"][4]["status"]
    assert all(row["expected_error_percent"]["rigidity"] > 0.0 for row in data["rows"][:4])
    code, _, err = run(capsys, "export", tmp_path / "t.json", "--modelica", tmp_path / "t.txt")
    assert code == 2
    assert "full grid" in err

    code, out, _ = run(capsys, "export", tmp_path / "t.json", "--ross", tmp_path / "bearings.py")
    assert code == 0
    assert "drops the other 31" in out
    if subprocess.run([ROSS, "-c", "import ross"], capture_output=True, check=False).returncode:
        pytest.skip("no ROSS (ross-rotordynamics) here: give an interpreter that has it as ROSS_PYTHON")
    found = subprocess.run([ROSS, "-c", ROTOR], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    on, off = (np.array(x.split(), dtype=float) for x in re.findall("^hertz (.*)", found, re.M))
    added = np.array(re.search("^added (.*)", found, re.M)[1].split(), dtype=float).reshape(3, 3)
    tangent = np.array(data["rows"][0]["stiffness"])[:3, :3]
    tangent[2, :2] = tangent[:2, 2] = 0.0
    assert np.abs(added - tangent).max() < 1e-6 * tangent.max()
    assert np.sum(off < 1.0) == 6  # a free shaft
    assert np.sum(on < 1.0) == 1  # bearings without torsion
    assert (on >= off - 1.0).all()


@pytest.mark.parametrize("load", ["1 kN", "1 kN,3 kN"])
def test_modelica_file_is_read_back(tmp_path, capsys, load):
    over = ("--over", "nut.position=100 mm,300 mm", *(("--over", f"load={load}") if "," in load else ()))
    assert run(capsys, "table", "lin-case3", *over, "--quantities", "stiffness", "--out", tmp_path / "t.json")[0] == 0
    assert run(capsys, "export", tmp_path / "t.json", "--modelica", tmp_path / "t.txt")[0] == 0
    text = (tmp_path / "t.txt").read_text()
    assert text.startswith("#1\n")
    tables = {}
    for name, rows, columns, body in re.findall(r"^double (\w+)\((\d+),(\d+)\)\n((?:[^#d].*\n)+)", text, re.M):
        tables[name] = np.array(body.split(), dtype=float).reshape(int(rows), int(columns))
    rows = json.loads((tmp_path / "t.json").read_text())["rows"]
    axial = [row["stiffness"][2][2] for row in rows]
    if "," in load:
        assert tables["K_uz_uz"][1:, 0] == pytest.approx([100.0, 300.0])
        assert tables["K_uz_uz"][0, 1:] == pytest.approx([1.0, 3.0])
        assert tables["K_uz_uz"][1:, 1:].ravel() == pytest.approx(axial)
    else:
        column = int(re.search(r"# column (\d+): K_uz_uz", text)[1]) - 1
        assert tables["table"][:, column] == pytest.approx(axial)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--over", "nut.posit=1:2:2"), "did you mean position"),
        (("--over", "nut.position=100:200:2", "parsec"), "no such unit"),
        (("--over", "load=1:2"), "KEY=A:B:N"),
        (("--quantities", "torque"), "preload"),
        (("--out", "t.xyz"), ".parquet"),
    ],
)
def test_unknown_key_unit_quantity_or_file_is_one_line(capsys, arguments, word):
    code, out, err = run(capsys, "table", "lin-case3", *arguments)
    assert (code, out) == (2, "")
    assert word in err
    assert len(err.splitlines()) == 1


def test_files_hold_every_row(tmp_path):
    found = rollbench.table("lin-case3", ["nut.position=100:900:2 mm"])
    assert found.converged == 1
    write_table(tmp_path / "t.csv", found)
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert len(lines) == 3
    assert "K_uz_uz" in lines[0]
    parquet = pytest.importorskip("pyarrow.parquet")
    write_table(tmp_path / "t.parquet", found)
    assert parquet.read_table(tmp_path / "t.parquet")["K_uz_uz"][0].as_py() == found.rows[0].stiffness[2, 2]


def test_netcdf_has_the_grid(tmp_path):
    xarray = pytest.importorskip("xarray")
    found = rollbench.table("lin-case3", ["nut.position=100:900:2 mm"])
    write_table(tmp_path / "t.nc", found)
    read = xarray.open_dataset(tmp_path / "t.nc", engine="scipy")
    assert read["stiffness"].shape == (2, 6, 6)
    assert np.array_equal(read["stiffness"][0], found.rows[0].stiffness)
