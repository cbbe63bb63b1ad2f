"""The benchmark BSCB-1: its answers are today's, a score tells right from wrong, other programs read its files."""

import csv
import hashlib
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from rollbench.comparison.errors import InputError
from rollbench.comparison.models.modelling import varied
from rollbench.comparison.scenes import catalogue, scene_file
from rollbench.comparison.wings.benchmark import answers, exporting, scoring, step_files
from rollbench.comparison.wings.benchmark.command import run_score
from rollbench.comparison.wings.benchmark.neutral import described
from rollbench.comparison.wings.benchmark.problems import JUNCTION, PROBLEMS, RUNS, fixed_text, key_of
from rollbench.comparison.wings.crosscheck.calculix import run_calculix
from rollbench.comparison.wings.crosscheck.export_deck import run
from rollbench.hifi.several_sets import bodies_of
from rollbench.meshes import axis, gmsh_session, parts, solid

pytestmark = pytest.mark.xdist_group("benchmark")
KEYS = json.loads((answers.HERE / answers.KEYS).read_text(encoding="utf-8"))
WHOLE = [name for name, one in PROBLEMS.items() if isinstance(one.described, parts.Scene)]


def rows(name, factor=1.0, without=""):
    """A file's rows of a problem, its loads times a factor, without one contact."""
    found = answers.shipped()[name]
    return [f"{name},{c},{factor * a.load!r}" for c, a in found.items() if c != without and a.load > 0.0]


def file(folder, lines, head="problem,contact,load_N"):
    path = folder / "loads.csv"
    path.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["wide-ellipse", "near-face", "double-nut"])
def test_shipped_answers_are_those_of_the_stored_runs(name):
    found, key = answers.computed(PROBLEMS[name])
    shipped = answers.shipped()[name]
    assert list(found) == list(shipped)
    assert KEYS[name] == key
    for contact, one in found.items():
        assert shipped[contact].load == pytest.approx(one.load, rel=1e-6)
        assert shipped[contact].uncertainty == pytest.approx(one.uncertainty, rel=6e-3)
        assert shipped[contact].beside == pytest.approx(one.beside, rel=1e-5)
        assert bool(one.beside) == (one.load > 0.0)


def test_stored_runs_of_the_benchmark_are_those_of_its_own_scenes():
    kept = {run for one in KEYS.values() for run in one["runs"]}
    assert {path.name for path in RUNS.glob("*.json")} <= kept


def test_answers_of_another_state_are_refused(monkeypatch):
    monkeypatch.setattr(answers, "key_of", lambda described: key_of(described) + "x")
    answers.shipped.cache_clear()
    with pytest.raises(InputError, match=r"another state of the problem.*benchmark compute"):
        answers.shipped()
    monkeypatch.undo()
    answers.shipped.cache_clear()
    assert len(answers.shipped()) == 12


def test_the_junction_is_what_the_variants_of_two_screws_say():
    found = [e for name in ("lin-case1", "lin-case3") for e in varied(catalogue.scene(name))]
    changes = [e.error.max_percent for e in found if e.variant.startswith("junction")]
    assert len(changes) == 6
    assert 0.8 * JUNCTION < max(changes) < JUNCTION


def test_right_loads_pass_and_all_problems_are_asked_for(tmp_path):
    assert run_score(file(tmp_path, [line for name in PROBLEMS for line in rows(name)])).code == 0
    found = run_score(file(tmp_path, rows("two-balls")))
    assert found.code == 1
    assert {p["problem"] for p in found.data["problems"] if p["passed"]} == {"two-balls"}
    assert run_score(file(tmp_path, rows("two-balls")), "two-balls").code == 0


@pytest.mark.parametrize("name", PROBLEMS)
def test_loads_three_percent_off_fail_with_the_worst_contact_named(name, tmp_path):
    found = run_score(file(tmp_path, rows(name, 1.03)), name)
    loads = {c: a.load for c, a in answers.shipped()[name].items()}
    heavy = max(loads, key=loads.get)
    assert (found.code, found.data["problems"][0]["worst"]) == (1, heavy)
    assert any(isinstance(part, str) and f"beyond tolerance: {heavy}: load" in part for part in found.parts)


def test_a_missing_contact_is_named_but_one_that_the_answer_has_lost_which_may_not_carry(tmp_path):
    found = run_score(file(tmp_path, rows("two-balls", without="2 NR")), "two-balls")
    assert (found.code, found.data["problems"][0]["missing"]) == (1, ["2 NR"])
    assert "two-balls: missing: 2 NR" in found.parts
    lost = next(c for c, a in answers.shipped()["clearance"].items() if a.load == 0.0)
    assert run_score(file(tmp_path, [*rows("clearance"), f"clearance,{lost},0"]), "clearance").code == 0
    found = run_score(file(tmp_path, [*rows("clearance"), f"clearance,{lost},20"]), "clearance")
    assert found.data["problems"][0]["beyond"][0]["contact"] == lost


BESIDE = [("angle_deg", lambda x: x + 0.4, lambda x: x - 0.6)]
BESIDE += [(c, lambda x: 1.02 * x, lambda x: 0.95 * x) for c in ("approach_um", "pressure_MPa")]


@pytest.mark.parametrize(("column", "right", "wrong"), BESIDE)
def test_what_stands_beside_a_load_is_judged_where_it_is_given(column, right, wrong):
    found = answers.shipped()["screw"]
    for change, passed in ((right, True), (wrong, False)):
        given = {c: scoring.Given(a.load, {column: change(a.beside[column])}) for c, a in found.items() if a.load > 0.0}
        result = scoring.score("screw", found, given)
        assert result.passed is passed
        assert {m.column for m in result.misses} == (set() if passed else {column})


REFUSED = [
    (["nonsense,1 SL,3"], (), "problem: got nonsense; allowed: two-balls"),
    (["two-balls,3 SL,3"], (), "got 3 SL; allowed: ball 1 to 2 and flank"),
    (["two-balls,1 SL,3", "two-balls,1 sl,3"], (), "line 3: contact: got two-balls, 1 SL again"),
    (["two-balls,1 SL,many"], (), "line 2: load_N: got many"),
    (["two-balls,1 SL,-3"], (), "line 2: load_N: got -3"),
    ([], (), "no contacts"),
    (["two-balls,1 SL,3"], ("nonsense",), "got nonsense"),
]


@pytest.mark.parametrize(("lines", "problem", "words"), REFUSED)
def test_a_file_that_cannot_be_judged_is_refused(lines, problem, words, tmp_path):
    with pytest.raises(InputError, match=words):
        run_score(file(tmp_path, lines), *problem)


def test_other_columns_and_separators_are_read(tmp_path):
    path = file(tmp_path, ["screw;1  sl;200,5;a;46,2"], "problem;contact;LOAD_N;remark;angle_deg")
    assert scoring.read(path, answers.shipped()) == {"screw": {"1 SL": scoring.Given(200.5, {"angle_deg": 46.2})}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("bscb")
    exporting.export(place, meshes=False, step_files=False, step=print)
    return place


def test_the_folder_is_small_its_hashes_hold_and_its_page_leaves_nothing_open(folder):
    files = [p for p in folder.rglob("*") if p.is_file()]
    assert sum(p.stat().st_size for p in files) < 5e6
    kept = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert kept["licence"].startswith("MIT")
    assert set(kept["files"]) == {str(p.relative_to(folder)) for p in files} - {"manifest.json"}
    for name, said in kept["files"].items():
        data = (folder / name).read_bytes()
        assert said == {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
    licence = (folder / "LICENSE.txt").read_text(encoding="utf-8")
    assert licence == answers.HERE.joinpath("LICENSE.txt").read_text(encoding="utf-8")
    assert "MIT License" in licence
    # its page leaves nothing open
    text = (folder / "README.html").read_text(encoding="utf-8")
    assert "$" not in text
    assert all(f"<td>{name}</td>" in text for name in PROBLEMS)
    from_schema = json.dumps(json.loads((folder / "schema.json").read_text(encoding="utf-8")))
    words = "stretch_meshed_by_the_reference bore_moves_as_rigid_body centre_x3_z3 shift_z azimuth_at_nut_centre"
    assert [word for word in words.split() if word not in text or word not in from_schema] == []


@pytest.mark.parametrize("name", PROBLEMS)
def test_plain_numbers_are_those_of_the_scene(name, folder):
    plain = json.loads((folder / "problems" / f"{name}.json").read_text(encoding="utf-8"))
    pytest.importorskip("jsonschema").validate(plain, exporting.schema())
    contacts = answers.shipped()[name]
    assert [b["number"] for s in plain["sets"] for b in s["balls"]] == list(range(1, len(contacts) // 4 + 1))
    track = plain["sets"][0]["helix"]
    for ball in plain["sets"][0]["balls"]:
        x, y, z = ball["centre"]
        assert np.hypot(x, y) == pytest.approx(track["pitch_radius"])
        low, high = plain["sets"][0]["nut"]["z"]
        along = track["lead"] * (ball["azimuth"] - track["azimuth_at_nut_centre"]) / (2.0 * np.pi)
        assert z == pytest.approx(0.5 * (low + high) + along, abs=1e-12)


@pytest.mark.parametrize("name", WHOLE)
def test_the_scene_leaves_no_dimension_to_an_assumption(name, folder):
    text = (folder / "problems" / f"{name}.toml").read_text(encoding="utf-8")
    found, meant = scene_file.read(text, f"{name}.toml"), PROBLEMS[name].described
    assert text == fixed_text(PROBLEMS[name])
    written, ours = solid.dimensions(found), solid.dimensions(meant)
    assert written.assumed[0].startswith(("The groove runs", "Flat ends"))
    assert (written.land, written.hole, written.shaft) == pytest.approx((ours.land, ours.hole, ours.shaft), rel=1e-9)
    assert (written.nut_held, written.screw_held) == (ours.nut_held, ours.screw_held)
    said = tuple(words for words in meant.assumed if not words.startswith("The former key"))
    assert replace(found, solid=meant.solid, name=meant.name) == replace(meant, assumed=said)


def test_step_files_open_in_gmsh(tmp_path):
    written = (step_files.write_step(PROBLEMS[name], tmp_path) for name in ("two-balls", "three-balls"))
    files = {path.stem: worst for found in written for path, worst in found.items()}
    assert {name for name, worst in files.items() if worst == 0.0} == {"two-balls", "three-balls"}
    assert 0.0 < files["three-balls-grooves"] < 1e-6
    volumes = {}
    with gmsh_session.session() as gmsh:
        for name in files:
            gmsh.model.add(name)
            gmsh.model.occ.importShapes(str(tmp_path / f"{name}.step"))
            gmsh.model.occ.synchronize()
            volumes[name] = sorted(gmsh.model.occ.getMass(*e) for e in gmsh.model.getEntities(3))
            if name == "three-balls-grooves":
                assert len(gmsh.model.getEntities(2)) == 4
    ball = 4.0 / 3.0 * np.pi * 4.005**3
    r = np.linspace(18.4 - 4.0, 18.4, 200001)[:-1]  # the groove of the inner ring: 2 pi r times its width at r
    centre, radius = 20.0 + 0.4 * np.cos(np.pi / 4.0), 4.4
    width = 2.0 * np.maximum(np.sqrt(np.maximum(radius**2 - (r - centre) ** 2, 0.0)) - 0.4 * np.sin(np.pi / 4.0), 0.0)
    inner = np.pi * (18.4**2 - 11.0**2) * 14.0 - float((2.0 * np.pi * r * width).sum() * (r[1] - r[0]))
    assert volumes["two-balls"][:3] == pytest.approx([ball, ball, inner], rel=1e-5)
    assert len(volumes["two-balls"]) == 4
    assert not volumes["three-balls-grooves"]


def test_the_distance_from_a_flank_is_seen():
    scene = PROBLEMS["screw"].described
    points = step_files._surface(scene, 3, np.radians([20.0, 45.0, 60.0]), 2.0, 0.0)
    assert np.abs(step_files.off(scene, 3, points, 0.0)).max() < 1e-12
    assert np.abs(step_files.off(scene, 3, 1.0001 * points, 0.0)).max() > 5e-7


@pytest.mark.parametrize(("name", "radius"), [("two-balls", 4e-3), ("double-nut", 3.175e-3)])
def test_meshes_open_in_meshio_and_scikit_fem(name, radius, tmp_path):
    meshio, skfem = pytest.importorskip("meshio"), pytest.importorskip("skfem")
    paths = exporting.write_meshes(PROBLEMS[name], tmp_path)
    assert [path.name for path in paths] == [f"{name}-{part}.vtu" for part in ("screw", "nut", "ball")]
    meshes = [skfem.MeshTet2.load(path) for path in paths]
    assert [mesh.t.shape[1] for mesh in meshes] == [len(meshio.read(path).cells_dict["tetra10"]) for path in paths]
    ball = skfem.Basis(meshes[-1], skfem.ElementTetP2())
    volume = skfem.Functional(lambda w: 1.0 + 0.0 * w.x[0]).assemble(ball)
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * radius**3, rel=2e-3)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_solves_the_deck_of_an_exported_scene(folder, tmp_path):
    """Half an element across the short half axis is far too few: the contacts come out too stiff, none by more than 80 N of
    500 (24 N with a whole one); those of a ball, which balance it, agree."""
    pytest.importorskip("gmsh")
    scene = catalogue.scene(str(folder / "problems" / "two-balls.toml"))
    run("ccx", "mm", "", 0.5, 0.9, 2e8, scene, tmp_path / "deck.inp")
    found = run_calculix((tmp_path / "deck.inp").read_text(encoding="utf-8"), tmp_path)
    loads = {s.removeprefix("BALL").replace("_", " "): float(np.linalg.norm(x)) for s, x in found.forces.items()}
    with (folder / "contacts.csv").open(encoding="utf-8") as file:
        answers = {row["contact"]: float(row["load_N"]) for row in csv.DictReader(file) if row["problem"] == "two-balls"}
    assert loads.keys() == answers.keys()
    assert all(0.0 < loads[name] - answer < 80.0 for name, answer in answers.items())
    for first, second in (("SL", "NR"), ("SR", "NL")):
        assert loads[f"1 {first}"] == pytest.approx(loads[f"1 {second}"], rel=1e-3)


def test_the_double_nut_is_meshed_as_its_first_set():
    scene = PROBLEMS["double-nut"].described
    assert isinstance(scene, axis.Assembly)
    plain = described(PROBLEMS["double-nut"])
    first, second = plain["sets"]
    assert first["stretch_meshed_by_the_reference"][1] == pytest.approx(second["stretch_meshed_by_the_reference"][0])
    assert bodies_of(scene)[0].shift == pytest.approx(first["stretch_meshed_by_the_reference"][0])
    assert (first["nut"]["shift_z"], second["nut"]["shift_z"]) == pytest.approx((-4e-6, 4e-6))


def test_a_decimal_comma_is_no_load_and_a_further_cell(tmp_path):
    with pytest.raises(InputError, match="decimal comma"):
        scoring.read(file(tmp_path, ["near-face,1 SL,489,517"]), answers.shipped())
