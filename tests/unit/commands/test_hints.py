"""Hints on the command line: commands that a shell takes as printed, names like a misspelt one, a limit that is a share."""

import shlex
import shutil

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.files import similar_paths
from rollbench.compare.scenes import catalogue, scene_file


def hinted(text: str) -> list[str]:
    """Words of the last command that a text names."""
    line = next(line for line in reversed(text.splitlines()) if "rollbench " in line)
    return shlex.split(line[line.rindex("rollbench ") :])


def test_names_of_files_are_quoted_where_a_shell_needs_it(command, tmp_path) -> None:
    file, loads = tmp_path / "my screw's.toml", tmp_path / "my loads.csv"
    assert hinted(command("new", file).out) == ["rollbench", "solve", str(file)]
    written = command("solve", file, "--model", "lin", "--loads-csv", loads).out
    assert hinted(written[written.index("rollbench check") :])[-1] == str(loads)
    shutil.copy(catalogue.shipped_toml_files("scenes")["two-balls"], tmp_path / "two balls.toml")
    out = command("compare", tmp_path / "two balls.toml", "--model", "lin", "--store", tmp_path).out
    assert hinted(out[: out.index("\n--verbose")])[:4] == [
        "rollbench",
        "solve",
        str(tmp_path / "two balls.toml"),
        "--condensed",
    ]
    plain = tmp_path / "plain.toml"
    assert command("new", plain).out.endswith(f" {plain}\n")


def test_a_kind_that_only_friction_solves_is_hinted_by_the_name_that_was_given(tmp_path) -> None:
    file = tmp_path / "my pair.toml"
    file.write_text(catalogue.shipped_scene_text("lin-pair-a"), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        catalogue.scene(str(file))
    assert hinted(caught.value.advice) == ["rollbench", "friction", str(file)]


@pytest.mark.parametrize("typed", ["srcew 40.toml", "Screw-40.toml", "screw40.toml"])
def test_a_misspelt_file_has_a_suggestion(tmp_path, typed: str) -> None:
    (tmp_path / "screw 40.toml").write_text("", encoding="utf-8")
    (tmp_path / "screw 40.csv").write_text("", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        scene_file.read_scene_file(tmp_path / typed)
    assert f"did you mean {shlex.quote(str(tmp_path / 'screw 40.toml'))}?" in str(caught.value)


def test_further_suggestions(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="did you mean two-balls"):
        catalogue.scene_of_any_kind("tow-balls.toml")
    (tmp_path / "Mine.toml").write_text("", encoding="utf-8")
    for typed in ("mine", "Mine.tml", "mien.toml"):
        with pytest.raises(InputError, match=r"did you mean Mine\.toml"):
            catalogue.scene_of_any_kind(typed)
    (tmp_path / "loads.csv").write_text("", encoding="utf-8")
    assert similar_paths(tmp_path / "laods.csv") == f"did you mean {tmp_path / 'loads.csv'}?"
    assert similar_paths(tmp_path / "none" / "laods.csv") == ""
    with pytest.raises(InputError, match="rollbench list"):
        catalogue.scene_of_any_kind("xyzxyz.toml")


@pytest.mark.parametrize(("given", "meant"), [("0.07", "7 %"), ("0.05", "5 %")])
def test_a_limit_that_looks_like_a_share_is_asked_about(command, given: str, meant: str) -> None:
    found = command("check", "two-balls", "--no-compute", "--max-error", given)
    assert f"do you mean {meant}?" in found.out
    assert found.code in (1, 3), "it is judged all the same"
    assert "do you mean" not in command("check", "two-balls", "--no-compute", "--max-error", "0.4").out
    assert f"do you mean {meant}?" in command("check", "two-balls", "--no-compute", "--limit", f"rigidity={given}").out
    assert "do you mean" not in command("check", "two-balls", "--no-compute", "--limit", "angle=0.1").out
