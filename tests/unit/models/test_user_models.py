"""Models of other packages: judged as ours are, loaded when they are named, and what they answer is checked."""

import json
import re
import sys
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.errors import InputError
from rollbench.compare.models import user_models
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.meshes.errors import draw_geometry_with_errors, scene_with_drawn_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FourierTerm, SideErrors

EXAMPLE = ROOT / "docs/examples/mei_model"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Installs a model with the text of its module, under a name."""

    def install(text, point="mine_module:model", name="mine"):
        module = point.partition(":")[0]
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n", encoding="utf-8")
        (info / "entry_points.txt").write_text(f"[rollbench.models]\n{name} = {point}\n", encoding="utf-8")
        monkeypatch.delitem(sys.modules, module, raising=False)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.chdir(tmp_path)
        forget()

    yield install
    monkeypatch.undo()
    forget()


#: A model that nothing carries.
ZEROS = "import numpy as np\n\n\ndef model(scene):\n    return np.zeros((scene.ball_count, 4))\n"


def forget():
    user_models.entry_points_of_installed_models.cache_clear()
    user_models.load_user_model.cache_clear()


@pytest.fixture
def example(installed):
    """The example of the manual, as its pyproject.toml names it."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    ((name, point),) = project["entry-points"]["rollbench.models"].items()
    installed((EXAMPLE / "mei_model.py").read_text(encoding="utf-8"), point, name)
    yield name
    sys.modules.pop("mei_model", None)


def test_the_example_finds_the_loads_of_mei(example):
    mine, ours = rollbench.solve("lin-case1", example), rollbench.solve("lin-case1", "mei")
    np.testing.assert_allclose(mine.loads, ours.loads, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(mine.displacement, ours.displacement, rtol=1e-9, atol=1e-15)
    assert pytest.approx(ours.life.L10, rel=1e-9) == mine.life.L10
    assert (mine.worst.element, mine.worst.pressure) == (ours.worst.element, pytest.approx(ours.worst.pressure, rel=1e-9))
    assert mine.to_dict()["equilibrium"]["force_residual"] < 1e-10
    assert mine.to_dict()["warnings"] == []


def test_the_function_of_the_manual_s_page_is_a_model(installed):
    page = (ROOT / "docs/tutorials/your-model.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"%%writefile equal_shares.py\n((?:.|\n)*?)```", page)
    installed(text, *re.findall(r'\nequal-shares = "(equal_shares:contact_loads)"', page))
    loads = rollbench.solve("lin-case1", "mine").loads
    np.testing.assert_allclose(loads[:, [0, 3]], rollbench.solve("lin-case1", "mei").loads[:, 0].mean(), rtol=1e-9)


def test_it_is_compared_and_judged_as_ours_are(example, command):
    found = rollbench.compare_models("lin-case1", [example, "mei"])
    mine, ours = found.models[example], found.models["mei"]
    assert mine.errors == pytest.approx(ours.errors, abs=1e-9)
    assert (mine.ball, mine.side, mine.seconds > 0.0) == (ours.ball, ours.side, True)
    assert found.expected_error.loads is None
    assert "your model has not been compared with the 3D reference" in found.expected_error.words
    code, out, _ = command("compare", "lin-case1", "--model", example, "mei", "--json")
    answers = json.loads(out)["scenes"][0]["answers"]
    assert (code, answers[example]["loads"]["max_N"]) == (0, pytest.approx(answers["mei"]["loads"]["max_N"], abs=1e-9))
    rows = [row for row in json.loads(out)["rows"] if row["model"] == example]
    assert not [row for row in rows if row["quantity"].startswith("centreline")], "it is known at the nut's centre only"
    verdicts = [command("check", "lin-case1", "--no-compute", "--model", name)[:2] for name in (example, "mei")]
    assert verdicts[0][0] == verdicts[1][0] == 1
    assert verdicts[0][1] == verdicts[1][1].replace("mei", example)


def test_specimens_and_samples_are_solved_by_it(example, command, tmp_path):
    scene = catalogue.scene("lin-random")
    for member in (0, 3):
        mine, ours = (
            run_model(scene, name, ModelOptions(member=member, engine="interpreted")) for name in (example, "mei")
        )
        np.testing.assert_allclose(mine.load, ours.load, rtol=0.0, atol=1e-8)
    code, out, _ = command("solve", "lin-random", "--members", "3", "--model", example, "--json")
    assert (code, json.loads(out)["model"]) == (0, example)
    words = ("sweep", "lin-case1", "--vary", "loads[0].force[2]=1 kN:5 kN", "--samples", "3", "--method", "grid")
    for name in (example, "mei"):
        assert command(*words, "--model", name, "--out", name)[0] == 0
    tables = [np.genfromtxt(tmp_path / name / "samples.csv", delimiter=",", names=True) for name in (example, "mei")]
    np.testing.assert_allclose(tables[0]["largest_load_N"], tables[1]["largest_load_N"], rtol=1e-10)


def test_a_specimen_is_written_into_its_scene():
    scene = catalogue.scene("lin-random")
    groove = SideErrors(
        profile=(1e-6, 2e-6), profile_sigma=(1e-7,) * 3, pitch=(FourierTerm(1.0, 3e-6, 0.0, 1e-6),), pitch_along="axis"
    )
    scene = replace(scene, errors=replace(scene.errors, SR=groove, NL=replace(groove, roundness=groove.pitch)))
    layout = ball_layout(scene)
    drawn, written = (
        draw_geometry_with_errors(scene, layout, 2),
        draw_geometry_with_errors(scene_with_drawn_errors(scene, 2), layout),
    )
    for what in ("ball_radii", "groove_centres", "groove_centre_derivatives", "groove_radii", "profile_coefficients"):
        np.testing.assert_allclose(getattr(written, what), getattr(drawn, what), rtol=1e-14, atol=0.0)
    assert not scene_with_drawn_errors(scene, 2).errors.random


def test_pressure_that_it_gives_is_shown_and_judged(installed, command):
    installed(
        "import numpy as np, rollbench\n"
        "def model(scene):\n"
        "    loads = rollbench.solve(scene, 'mei').loads\n"
        "    return rollbench.ModelAnswer(loads, pressure=np.where(loads > 0.0, 3e9, 0.0))\n"
    )
    assert rollbench.solve("lin-case1", "mine").pressure.max() == 3e9
    compared = rollbench.compare_models("lin-case1", ["mine"]).models["mine"]
    assert (compared.pressure, np.isnan(compared.displacement)) == (3e9, True)
    code, out, _ = command("solve", "lin-case1", "--model", "mine", "--json")
    summary = json.loads(out)["summary"]
    assert (code, summary["worst_contact"]["pressure_MPa"]) == (0, 3000.0)
    assert summary["axial"]["displacement_um"] is summary["rigidities_N_per_um"]["with_unequal_loads"] is None
    words = ("check", "lin-case1", "--no-compute", "--max-error", "90", "--limit", "pressure=10", "--model", "mine")
    assert "against 2" in command(*words)[1]


LOADS = "import numpy as np\ndef model(scene):\n    loads = np.zeros((scene.ball_count, 4))\n"
#: Faulty models: module, and what the error names.
FAULTY = {
    "shape": (LOADS + "    return loads[:, :2]", "loads of shape (32, 2) from mine; allowed: an array of shape (32, 4)"),
    "nan": (LOADS + "    loads[3, 1] = np.nan\n    return loads", "loads of nan on ball 4, SR"),
    "negative": (LOADS + "    loads[0, 2] = -5.0\n    return loads", "loads of -5 on ball 1, NL"),
    "words": (LOADS + "    return 'ten'", "loads from mine that are not numbers"),
    "displacement": (
        LOADS + "    from rollbench import ModelAnswer\n    return ModelAnswer(loads, displacement=np.zeros(3))",
        "displacement of shape (3,)",
    ),
    "exception": ("def model(scene):\n    raise RuntimeError('no\\nlicence')", "mine fails with RuntimeError: no licence"),
    "import": ("import absent_solver", "No module named 'absent_solver'"),
    "attribute": ("", "AttributeError"),
    "number": ("model = 3", "an object of type int instead of a function"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_a_faulty_model_is_one_error(installed, command, fault):
    text, expected = FAULTY[fault]
    installed(text)
    for words in (("solve", "lin-case1"), ("compare", "lin-case1"), ("check", "lin-case1", "--no-compute")):
        code, out, err = command(*words, "--model", "mine")
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert expected in err


def test_it_is_named_by_list_and_not_loaded(installed, command):
    installed("raise RuntimeError('loaded')")
    code, out, _ = command("list", "--json")
    assert (code, json.loads(out)["models of other packages"]) == (0, {"mine": "mine_module:model, mine_module 1.0"})
    assert "mine_module:model" in command("list")[1]
    code, _, err = command("solve", "lin-case1", "--model", "mein")
    assert (code, "mine; advice: did you mean" in err) == (2, True), err
    assert command("solve", "lin-case1", "--model", "mei")[0] == 0


def test_a_name_of_ours_stays_ours(installed, command):
    installed("raise RuntimeError('loaded')", name="mei")
    assert "models of other packages" not in json.loads(command("list", "--json")[1])
    assert command("solve", "lin-case1", "--model", "mei")[0] == 0


def test_a_name_of_two_packages_is_refused(installed):
    installed(ZEROS, "first_module:model")
    installed(ZEROS, "second_module:model")
    with pytest.raises(InputError, match="also has this name"):
        rollbench.solve("lin-case1", "mine")


def test_several_sets_on_one_shaft_are_refused_in_one_line(installed, command):
    installed(LOADS + "    return loads")
    for words in (("solve", "double-nut"), ("check", "double-nut", "--no-compute")):
        code, out, err = command(*words, "--model", "mine")
        assert (code, out, err.count("\n"), "mine does not solve several" in err) == (2, "", 1, True), err
    code, _, err = command("sweep", "double-nut", "--vary", "errors.seed=1:2", "--model", "mine")
    assert code == 2
    assert "mine" in err


def test_loads_that_do_not_balance_are_warned_of(installed, command):
    installed("import rollbench\ndef model(scene):\n    return rollbench.solve(scene, 'mei').loads / 1000.0\n")
    code, out, _ = command("solve", "lin-case1", "--model", "mine")
    assert code == 0
    assert "loads of mine out of balance by" in out
