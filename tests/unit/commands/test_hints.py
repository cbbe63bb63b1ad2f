"""Hints on the command line: commands that a shell takes as printed, names like a misspelt one, a limit that is a share."""

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.files import similar_paths
from rollbench.compare.scenes import catalogue

SUGGESTED = {
    "'screw 40.toml'": ("srcew 40.toml", "Screw-40.toml", "screw40.toml"),
    "Mine.toml": ("mine", "Mine.tml", "mien.toml"),
    "two-balls": ("tow-balls.toml",),
    "": ("xyzxyz.toml",),
}


@pytest.mark.parametrize("meant", SUGGESTED)
def test_a_misspelt_file_has_a_suggestion(tmp_path, monkeypatch, meant: str) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("screw 40.toml", "screw 40.csv", "Mine.toml", "loads.csv"):
        (tmp_path / name).write_text("", encoding="utf-8")
    for typed in SUGGESTED[meant]:
        with pytest.raises(InputError, match=f"did you mean {meant}" if meant else "rollbench list"):
            catalogue.scene_of_any_kind(typed)
    assert similar_paths(tmp_path / "laods.csv") == f"did you mean {tmp_path / 'loads.csv'}?"


@pytest.mark.parametrize(("given", "meant"), [("0.07", "7 %"), ("0.05", "5 %")])
def test_a_limit_that_looks_like_a_share_is_asked_about(command, given: str, meant: str) -> None:
    words, asked = ("check", "two-balls", "--no-compute"), f"do you mean {meant}?"
    found = command(*words, "--max-error", given)
    assert asked in found.out
    assert found.code in (1, 3), "it is judged all the same"
    assert asked in command(*words, "--limit", f"rigidity={given}").out
    for usual in (("--max-error", "0.4"), ("--limit", "angle=0.1")):
        assert "do you mean" not in command(*words, *usual).out
