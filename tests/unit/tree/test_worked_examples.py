"""What a newcomer adds (a key, a quantity, a model, a paper) in the places that CONTRIBUTING names, tried in a copy."""

import json
import re

import pytest
from tests import acme
from tests.copies import ROOT, copy_of_tree, python, rollbench

from rollbench.compare.scenes import catalogue

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("worked examples")]

MODEL = """
    Model("lin-rigid-screw", "lin with a rigid screw", "the source's model, screw rigid", "screw and nut rigid", _solve_lin,
          compared=True, ingredients=(("screw", "rigid"),)),
"""
PAPER_TEST = """
import pytest, tests.sources.entries as entries
@pytest.mark.parametrize("key", entries.keys("acme-1"))
def test_entry(key):
    entries.check(key)
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    helpers = ("evidence_study.py", "sources/entries.py", "shipped_texts.py")
    return copy_of_tree(tmp_path_factory.mktemp("worked") / "tree", helpers)


def change(tree, file, pattern, new):
    """Change the one place of a file that fits."""
    path = tree / file
    text, count = re.subn(pattern, new, path.read_text(encoding="utf-8"), count=1)
    assert count == 1, (file, pattern)
    path.write_text(text, encoding="utf-8")


def found(done, code=0):
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


def test_a_key_of_the_scene_takes_two_places(tree, tmp_path):
    """A field of its record, template: read with its unit, refused with another, no stored run lost."""
    line = '    wear: ranges.Deviation = frozen_default(0.0, "depth that the nut\'s lands have lost", "2 um")\n'
    change(tree, "meshes/parts.py", r"(class Solid:(?:.|\n)*?)(    nut_inner_diameter: )", rf"\1{line}\2")
    change(tree, "compare/template.toml", r"(?m)^(# hole_diameter = )", r'# wear = "0 um"\n\1')
    assert '"wear"' in rollbench(tree, "schema", cwd=tmp_path).stdout
    rollbench(tree, "new", "my.toml", cwd=tmp_path)
    text = (tmp_path / "my.toml").read_text(encoding="utf-8").replace("# [solid]", "[solid]")
    assert '# wear = "0 um"' in text
    for value, code in (("2 N", 2), ("2 um", 0)):
        (tmp_path / "worn.toml").write_text(text.replace('# wear = "0 um"', f'wear = "{value}"'), encoding="utf-8")
        done = rollbench(tree, "solve", "worn.toml", "--model", "lin", cwd=tmp_path)
        assert (done.returncode, "solid.wear: got" in done.stderr) == (code, code == 2), done.stderr
    said = "import rollbench; print(rollbench.read('worn.toml').solid.wear)"
    assert python(tree, "-c", said, cwd=tmp_path).stdout == "2e-06\n"
    assert rollbench(tree, "check", "lin-case1", "--no-compute", cwd=tmp_path).returncode == 0


def test_a_quantity_takes_its_field_and_its_value(tree, tmp_path):
    """Mean pressure of the worst contact: JSON and table follow."""
    field = (
        '    mean_pressure: float = quantity_field("mean_pressure_MPa", "its mean pressure, 2/3 of the highest", '
        'heading="mean pressure")\n'
    )
    change(tree, "lowfi/rating/contacts.py", r"(class BallContact:(?:.|\n)*?)(    #: Static safety)", rf"\1{field}\2")
    change(tree, "lowfi/rating/contacts.py", r"(return BallContact\(.*)(, safety\))\n", r"\1, highest / 1.5\2\n")
    words = ("solve", "lin-case1", "--model", "lin")
    contact = found(rollbench(tree, *words, "--json", cwd=tmp_path))["summary"]["worst_contact"]
    assert contact["mean_pressure_MPa"] == pytest.approx(contact["pressure_MPa"] / 1.5, rel=1e-12)
    assert "mean pressure" in rollbench(tree, *words, cwd=tmp_path).stdout


def test_a_model_takes_one_place(tree, tmp_path):
    """Its record: list, solve and compare know it, and its answer is another than that of the model it is a variant of."""
    change(tree, "compare/models/registry.py", r"_ALL = \(\n", "_ALL = (" + MODEL)
    assert "lin-rigid-screw" in found(rollbench(tree, "list", "--json", cwd=tmp_path))["models"]
    solved = found(rollbench(tree, "solve", "two-balls", "--model", "lin-rigid-screw", "--json", cwd=tmp_path))
    assert (solved["model"], solved["status"]) == ("lin-rigid-screw", "converged")
    words = ("compare", "lin-case1", "--model", "lin", "lin-rigid-screw", "--json")
    answers = found(rollbench(tree, *words, cwd=tmp_path))["scenes"][0]["answers"]
    rigid, elastic = (answers[name]["loads"]["max_N"] for name in ("lin-rigid-screw", "lin"))
    assert rigid != pytest.approx(elastic, rel=1e-3)


def test_a_contact_law_takes_one_place(tree, tmp_path):
    """Contacts 1.1 times as stiff, by the one function of the law: another answer in balance for one set and several."""
    law = r"= x\*\*3, 1.5 \* x / c, 0.4 \* c \* x\*\*5"
    stiffer = "= 1.1 * x**3, 1.65 * x / c, 0.44 * c * x**5"
    commands = [("solve", name, "--model", "lin", "--json") for name in ("lin-case1", "double-nut")]
    before = [found(rollbench(tree, *words, cwd=tmp_path)) for words in commands]
    change(tree, "lowfi/statics/contact_law.py", law, stiffer)
    for words, old in zip(commands, before, strict=True):
        new = found(rollbench(tree, *words, cwd=tmp_path))
        assert new["status"] == old["status"] == "converged"
        assert new["equilibrium"]["force_residual"] < 1e-9
        moved = new["summary"]["load_point"]["displacement_um"] / old["summary"]["load_point"]["displacement_um"]
        assert 1.1 ** (-2.0 / 3.0) < moved < 0.995, moved


def test_a_paper_takes_two_folders_and_its_record(tree, tmp_path):
    """Its folder in compare/cases, its line in CASES, its tests in tests/sources: traced, judged, in the report, tested."""
    acme.write(tree / "compare/cases/acme", catalogue.shipped_scene_text("two-balls"))
    case = 'Case("acme", "Acme (1901)", "rollbench.compare.cases.acme", "page")'
    change(tree, "compare/case.py", r"CASES = \(\n", f"CASES = ({case},")
    test = tree / "tests/sources/acme/literature/test_acme.py"
    test.parent.mkdir(parents=True)
    test.write_text(PAPER_TEST, encoding="utf-8")
    judge, table = ("check", "--printed", "--only", "acme-1", "--json"), "compare/cases/acme/printed/acme-1.toml"
    judged = found(rollbench(tree, *judge, cwd=tmp_path))
    assert [row["verdict"] for row in judged["entries"]] == ["reproduced"] * 2
    change(tree, table, 'verdict = "reproduced"\n', "")
    judged = found(rollbench(tree, *judge, cwd=tmp_path), 1)
    assert judged["changed_verdicts"] == ["acme-1:modulus: no expected verdict is stored, the actual verdict is reproduced"]
    change(tree, table, 'class = "hard"\n', 'class = "hard"\nverdict = "reproduced"\n')
    row = found(rollbench(tree, "list", "--table", "acme-1", "--json", cwd=tmp_path))[0]
    assert row["test"] == "tests/sources/acme/literature/test_acme.py::test_entry[acme-1:modulus]"
    done = rollbench(tree, "report", "--only", "acme", "--stored", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "113.9" in (tmp_path / "out/tables/acme-1.csv").read_text(encoding="utf-8")
    tests = python(tree, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/sources/acme", cwd=tree)
    assert "2 passed" in tests.stdout, tests.stdout


def test_contributing_names_the_places_that_these_change():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    places = "meshes/parts.py", "compare/template.toml", "compare/models/registry.py", "compare/case.py", "tests/sources"
    assert [place for place in places if f"`{place}`" not in text] == []
