"""A user's own loads in the place of the 3D reference: `check`, `compare`, `report SCENE`; its uncertainty decides."""

import re

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.gate.user import read_reference_file, uncertainty_warning
from rollbench.compare.reference import estimate
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import SIDES

SCENE = "two-balls"


GIVEN = catalogue.scene(SCENE)


def written(path, *notes: str, factor: float = 1.0, column: str = "", each: float = 0.0):
    """The stored reference's own loads, that of ball 2 SR times a factor."""
    load = estimate.reference_of_scene(GIVEN).load.copy()
    load[1, 1] *= factor
    heads = "ball,flank,newton" + (f",{column}" if column else "")
    rows = [f"{b + 1},{s},{load[b, k]:.9g}{f',{each}' if column else ''}" for b in range(2) for k, s in enumerate(SIDES)]
    path.write_text("\n".join([*notes, heads, *rows]) + "\n", encoding="utf-8")
    return path


def test_ones_own_reference_flips_a_verdict(command, tmp_path) -> None:
    file = written(tmp_path / "bench.csv", "# provenance: load cells of 2026,,", "#uncertainty: 1 %", factor=1.2)
    assert command("check", SCENE, "--no-compute").code == 0
    assert command("check", SCENE, "--reference", file).code == 1
    wide = written(tmp_path / "bench.csv", "# uncertainty: 12 %", factor=1.2)
    assert command("check", SCENE, "--reference", wide).code == 3, "an uncertainty that leaves it open"
    same = written(tmp_path / "same.csv")
    code, found = command.json("check", SCENE, "--reference", same, "--loads", file, "--json")
    (verdict,) = found["verdicts"]
    assert (code, verdict["word"], verdict["levels"]) == (1, "fail", [])
    assert "whose uncertainty is taken as zero" in verdict["detail"]
    assert "by the stored 3D reference: 20.00 % - 0.44 % > 7 %, fail" in verdict["detail"]


def test_uncertainty_by_column_by_note_or_zero(tmp_path) -> None:
    reference = estimate.reference_of_scene(GIVEN)
    for notes, column, each, expected in (
        ((), "", 0.0, 0.0),
        (("# uncertainty: 2 N",), "", 0.0, 2.0),
        (("# uncertainty: 0.5 %",), "", 0.0, 0.005 * reference.mean),
        ((), "uncertainty_kN", 0.003, 3.0),
        ((), "uncertainty_percent", 2.0, 0.02 * reference.load),
    ):
        found, unknown = read_reference_file(written(tmp_path / "a.csv", *notes, column=column, each=each), GIVEN)
        np.testing.assert_allclose(found.uncertainty, np.broadcast_to(expected, found.load.shape), rtol=1e-8)
        assert (unknown, found.label, found.levels) == ((), "a.csv", ())
    assert uncertainty_warning(found, 2.1) == ""
    assert "2 % at ball" in uncertainty_warning(found, 1.9)


FAULTY = [
    (("# uncertainty: lots",), {}, ("", ""), "0.5 %"),
    (("# uncertainty: -1 %",), {}, ("", ""), "0.5 %"),
    ((), {}, ("2,NR", "2,NX"), "SL, SR, NL, NR"),
    ((), {}, ("newton", "uncertainty_N"), "a column newton"),
    (("# uncertainty: 1 N",), {"column": "uncertainty_N", "each": 1.0}, ("", ""), "one column or one note"),
    ((), {}, (r"\d,NL,.*\n", ""), "no rows for NL"),
]


@pytest.mark.parametrize(("notes", "given", "change", "words"), FAULTY)
def test_faulty_references_are_refused(tmp_path, notes, given, change, words) -> None:
    file = written(tmp_path / "a.csv", *notes, **given)
    file.write_text(re.sub(*change, file.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_reference_file(file, GIVEN)


REFUSED = [
    (("check", SCENE, "lin-case1"), "one scene, not 2"),
    (("check", SCENE, "--levels", "2"), "only without --reference"),
    (("check", "double-nut"), "no rows of set 1"),
    (("check",), "state the scenes"),
    (("compare", SCENE, "lin-case1"), "for 2 scenes"),
    (("compare", SCENE, "--levels", "1"), "--levels"),
    (("compare", SCENE, "--fresh"), "--fresh"),
    (("compare", SCENE, "--model", "condensed"), "condensed bodies"),
    (("report",), "state the scene"),
]


@pytest.mark.parametrize(("tokens", "words"), REFUSED)
def test_what_it_cannot_stand_with_is_one_line(command, tmp_path, tokens: tuple[str, ...], words: str) -> None:
    assert words in command.refused(*tokens, "--reference", written(tmp_path / "a.csv"))


def test_compare_sets_models_and_ours_beside_it(command, tmp_path) -> None:
    file = written(tmp_path / "bench.csv", "# uncertainty: 1 %", factor=1.2)
    tokens = ("compare", SCENE, "--reference", file, "--store", tmp_path / "store")
    (scene,) = command.answer(*tokens)["scenes"]
    assert (scene["levels"], scene["uncertainty_percent"]) == ([], pytest.approx(1.0))
    moved = {name: answer["load_point"]["displacement_um"] for name, answer in scene["answers"].items()}
    assert (moved["bench.csv"], moved["stored 3D reference"] is None) == (None, False)
