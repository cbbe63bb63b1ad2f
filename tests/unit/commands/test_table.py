"""Tables of stiffness over a scene's keys, their files, and a rotor of ROSS on two of their rows."""

import csv
import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from tests.helpers import small_screw

import rollbench
from rollbench.compare.scenes.template import new_scene_text
from rollbench.compare.studies.table_files import ROSS_TERMS, modelica_table_text, ross_module_text, write_table_file
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics import static
from rollbench.meshes.parts import FREEDOMS, Support

#: An interpreter that has ROSS, if not this one.
ROSS = os.environ.get("ROSS_PYTHON", sys.executable)
#: Prints natural frequencies [Hz] of two shafts, one of steel and one that is a hundred thousand times as stiff, on two
#: rows of a table and free, and what the first row adds to the stiffness matrix of the rotor.
ROTOR = """
import inspect, json, numpy as np, ross, bearings
from scipy.linalg import eigh
found = {"takes": [x for x in inspect.signature(ross.BearingElement).parameters if x[0] == "k" and x != "kwargs"]}
for name, modulus in (("steel", 211e9), ("rigid", 211e14)):
    material = ross.Material(name, rho=7810, E=modulus, G_s=modulus / 2.6)
    shaft = [ross.ShaftElement(L=0.1, idl=0, odl=0.04, material=material) for _ in range(8)]
    free = [ross.BearingElement(n=n, kxx=0.0, cxx=0.0) for n in (2, 6)]
    rotors = [ross.Rotor(shaft, [], b) for b in ([bearings.bearing(2, 0), bearings.bearing(6, 1)], free)]
    for state, rotor in zip(("on rows", "free"), rotors):
        square = eigh(rotor.K(0), rotor.M(), eigvals_only=True)
        found[f"{name} {state}"] = (np.sqrt(square.clip(0.0)) / 2.0 / np.pi).tolist()
    found["mass"], added = rotors[0].m, rotors[0].K(0) - rotors[1].K(0)
    found["added"] = added[12:18, 12:18].tolist()
print("found", json.dumps(found))
"""


@pytest.fixture(scope="module")
def travel(tmp_path_factory):
    """The folder with the table of a screw of catalogue size over its travel, one place of which is beyond the thread."""
    folder = tmp_path_factory.mktemp("travel")
    (folder / "my.toml").write_text(new_scene_text("ball screw", "40x10"))
    found = rollbench.table(folder / "my.toml", ["nut.position=100:900:3 mm"], quantities=["stiffness", "pressure"])
    write_table_file(folder / "t.json", found)
    return folder, found


@pytest.fixture(scope="module")
def rotors(travel):
    """What `ROTOR` prints on the rows of `travel`."""
    folder, found = travel
    (folder / "bearings.py").write_text(ross_module_text(found))
    done = subprocess.run([ROSS, "-c", ROTOR], cwd=folder, capture_output=True, text=True, check=False)
    if "No module named 'ross'" in done.stderr:
        pytest.skip("no ROSS (ross-rotordynamics) here: install rollbench[ross], or name an interpreter by ROSS_PYTHON")
    assert done.returncode == 0, done.stderr
    return {k: np.array(x) for k, x in json.loads(re.search("^found (.*)", done.stdout, re.M)[1]).items()}


def test_a_row_has_its_answers_or_the_reason_why_it_has_none(travel, tmp_path):
    """A nut beyond the thread is refused; a CSV file holds that row too."""
    found = travel[1]
    assert [place["nut.position_mm"] for place in found.places] == [100.0, 500.0, 900.0]
    assert [row.converged for row in found.rows] == [True, True, False]
    assert 'nut.position: got "900 mm"' in found.rows[2].status
    for row in found.rows[:2]:
        assert min(row.load_error, row.rigidity_error, row.pressure_error) > 0.0
    write_table_file(tmp_path / "t.csv", found)
    rows = list(csv.DictReader((tmp_path / "t.csv").read_text().splitlines()))
    assert [row["nut.position_mm"] for row in rows] == ["100.0", "500.0", "900.0"]
    assert float(rows[1]["K_uz_rx"]) == found.rows[1].stiffness[2, 3]


def test_stiffness_of_a_row_against_finite_differences_of_the_solution(tmp_path):
    scene, motion = small_screw(4, oversize=4e-6), np.array([2e-6, -1e-6, 3e-6, 2e-5, -1e-5, 0.0])
    station = scene.nut.position

    def held(at):
        return replace(scene, supports=(Support(station, tuple(zip(FREEDOMS, map(float, at), strict=True))),), loads=())

    def reaction(at):
        balance = static.solve_elastic(held(at), backend=LADDER["refined"]).equilibrium
        arm = np.cross([0.0, 0.0, station], balance.reaction_force)
        return np.concatenate([balance.reaction_force, balance.reaction_moment - arm])

    (tmp_path / "held.toml").write_text(held(motion).to_toml())
    (row,) = rollbench.table(tmp_path / "held.toml", quantities=["stiffness"]).rows
    steps = np.diag([1e-8, 1e-8, 1e-8, 1e-6, 1e-6, 1e-6])
    measured = np.array([(reaction(motion + h) - reaction(motion - h)) / (2.0 * h.max()) for h in steps]).T
    size = np.sqrt(np.diag(measured))
    assert np.abs((row.stiffness - measured) / np.outer(size, size)).max() < 1e-4


def test_stiffness_of_one_set_of_several(tmp_path):
    file = tmp_path / "bearing.toml"
    file.write_text(new_scene_text("angular-contact bearing"))
    whole, alone = (rollbench.table(file, quantities=["stiffness"], stiffness_at=at).rows[0] for at in (None, "bearing"))
    (of_set,) = rollbench.solve(file).to_dict()["sets"]
    assert alone.stiffness == pytest.approx(np.array(of_set["stiffness"]), rel=1e-9)
    assert whole.nut_tangent > whole.load_point_tangent > 0.0


def test_ross_adds_the_terms_of_the_row_and_drops_the_others(travel, rotors):
    assert sorted(rotors["takes"]) == sorted(ROSS_TERMS)
    kept = np.zeros((6, 6))
    for at in ROSS_TERMS.values():
        kept[at] = travel[1].rows[0].stiffness[at]
    assert np.abs(rotors["added"] - kept).max() < 1e-6 * kept.max()


def test_natural_frequencies_of_ross_are_those_of_a_rigid_body_on_the_two_rows(travel, rotors):
    mass = float(rotors["mass"])
    inertia = mass * (3.0 * 0.02**2 + 0.8**2) / 12.0
    K = np.zeros((5, 5))
    for z, row in zip((-0.2, 0.2), travel[1].rows, strict=False):
        moved = np.array([[1, 0, 0, 0, z], [0, 1, 0, -z, 0], [0, 0, 1, 0, 0]], dtype=float)
        k = row.stiffness[:3, :3] * np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]])
        K += moved.T @ k @ moved
    square = eigh(K, np.diag([mass, mass, mass, inertia, inertia]), eigvals_only=True)
    assert rotors["rigid on rows"][1:6] == pytest.approx(np.sqrt(square) / 2.0 / np.pi, rel=1e-3)


def test_a_steel_rotor_of_ross_is_held_by_two_rows_and_free_without(rotors):
    on, off = rotors["steel on rows"], rotors["steel free"]
    assert np.sum(off < 1.0) == 6
    assert np.sum(on < 1.0) == 1  # it turns about its axis
    assert (on >= off - 1.0).all()  # springs lower no frequency


def read_back(text):
    """Tables of a file for CombiTables, by their names."""
    assert text.startswith("#1\n")
    found = re.findall(r"^double (\w+)\((\d+),(\d+)\)\n((?:[^#d].*\n)+)", text, re.M)
    return {name: np.array(body.split(), dtype=float).reshape(int(n), int(m)) for name, n, m, body in found}


def test_a_modelica_file_over_one_key_has_the_answers_and_says_what_it_leaves_out(travel, command):
    folder, found = travel
    out = command.said("export", folder / "t.json", "--modelica", folder / "t.txt")
    text = (folder / "t.txt").read_text()
    for said in (out, text):
        assert "left out: nut.position 900 mm: refused" in said
    table = read_back(text)["table"]
    column = int(re.search(r"# column (\d+): K_uz_uz", text)[1]) - 1
    assert table[:, 0] == pytest.approx([100.0, 500.0])
    assert table[:, column] == pytest.approx(found.stiffness[:2, 2, 2])


def test_a_modelica_file_over_two_keys_has_a_grid_of_each_term():
    found = rollbench.table("lin-case3", ["nut.position=300 mm,100 mm", "load=1 kN,3 kN"], quantities=["stiffness"])
    tables = read_back(modelica_table_text(found)[0])
    assert tables["K_uz_uz"][1:, 0] == pytest.approx([100.0, 300.0])
    assert tables["K_uz_uz"][0, 1:] == pytest.approx([1.0, 3.0])
    assert tables["K_rx_uy"][1:, 1:].ravel() == pytest.approx(found.stiffness[[2, 3, 0, 1], 3, 1])


def test_a_grid_with_gaps_is_no_modelica_file(command, tmp_path):
    found = rollbench.table("lin-case3", ["nut.position=100 mm,900 mm", "load=1 kN,3 kN"], quantities=["stiffness"])
    write_table_file(tmp_path / "t.json", found)
    assert "nut.position 900 mm, load 1 kN" in command.refused("export", tmp_path / "t.json", "--modelica", tmp_path / "t")


#: Units that files state, of some of their columns.
UNITS = {"nut.position_mm": "mm", "status": "", "nut_tangent_N_per_um": "N/um", "largest_pressure_MPa": "MPa"}
UNITS |= {
    "K_ux_uz": "N/m",
    "K_ux_ry": "N/rad",
    "K_rx_uy": "N m/m",
    "K_rz_rz": "N m/rad",
    "expected_error_percent_load": "%",
}


def test_a_parquet_file_holds_every_row(travel, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_table_file(tmp_path / "t.parquet", travel[1])
    column = parquet.read_table(tmp_path / "t.parquet")["K_uz_uz"].to_pylist()
    assert column == [*travel[1].stiffness[:2, 2, 2], None]
    fields = {
        field.name: (field.metadata or {}).get(b"unit", b"").decode()
        for field in parquet.read_schema(tmp_path / "t.parquet")
    }
    for found in (fields, pytest.importorskip("pandas").read_parquet(tmp_path / "t.parquet").attrs["units"]):
        assert {name: found.get(name, "") for name in UNITS} == UNITS


def test_netcdf_has_the_grid(travel, tmp_path):
    xarray = pytest.importorskip("xarray")
    write_table_file(tmp_path / "t.nc", travel[1])
    at = {"nut.position_mm": 500.0, "force": "uz", "freedom": "rx"}
    with xarray.open_dataset(tmp_path / "t.nc", engine="scipy") as read:
        named = {name: unit for name, unit in UNITS.items() if not name.startswith("K_")}
        assert {name: read[name].attrs.get("units", "") for name in named} == named
        term = read["stiffness"].sel(force="ux", freedom="ry")
        assert (str(term["force_unit"].item()), str(term["freedom_unit"].item())) == ("N", "rad")
        assert read["stiffness"].sel(at) == travel[1].stiffness[1, 2, 3]
