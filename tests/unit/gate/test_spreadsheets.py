"""Tables as spreadsheets save them: rows whose cells do not fit the headings, decimal commas, separators, encodings."""

from pathlib import Path

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.gate.judged import read_user_values
from rollbench.compare.gate.user import read_reference_file
from rollbench.compare.models.loads_file import read_loads
from rollbench.compare.scenes import catalogue

TWO = catalogue.scene("two-balls")
PLACES = [(ball, side) for ball in (1, 2) for side in ("SL", "SR", "NL", "NR")]


def written(folder: Path, head: str, row: str) -> Path:
    """A table with the same row for every contact of the two balls."""
    file = folder / "a.csv"
    rows = [row.format(ball=ball, side=side) for ball, side in PLACES]
    file.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return file


READERS = {
    "loads": ("ball,flank,newton", "{ball},{side},489,517", lambda file: read_loads(file, 2)),
    "kilonewtons": ("ball,flank,load_kN", "{ball},{side},0,489517", lambda file: read_loads(file, 2)),
    "shorter": ("ball,flank,newton,note", "{ball},{side},489,517,x", lambda file: read_loads(file, 2)),
    "filled up": ("ball,flank,newton,,", "{ball},{side},489,517,", lambda file: read_loads(file, 2)),
    "reference": ("ball,flank,newton", "{ball},{side},489,517", lambda file: read_reference_file(file, TWO)),
    "values": ("quantity,value,unit", "rigidity,540,5,N/um", read_user_values),
}


@pytest.mark.parametrize("name", READERS)
def test_a_cell_without_heading_is_refused_and_a_decimal_comma_named(tmp_path, name: str) -> None:
    head, row, read = READERS[name]
    with pytest.raises(InputError, match="decimal comma") as caught:
        read(written(tmp_path, head, row))
    assert caught.value.key == "line 2"
    assert row.format(ball=1, side="SL") in caught.value.value


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("ball,flank,newton", "{ball},{side},489.5,,"),
        ("ball,flank,newton,note", "{ball},{side},489.5"),
        ("ball,flank,newton,,", "{ball},{side},489.5"),
        (",ball,flank,newton", "7,{ball},{side},489.5"),
        ("ball;flank;newton", "{ball};{side};489,5"),
        ("sep=;\nball;flank;newton", "{ball};{side};489,5"),
        ("sep=|\nball|flank|newton", "{ball}|{side}|489,5"),
        ("SEP=,\nball,flank,newton", "{ball},{side},489.5"),
        ("ball,flank,Newton", "{ball},{side},489.5"),
        ("Ball,FLANK,LOAD_KN", "{ball},{side},0.4895"),
        ("ball,flank,Load [Kilonewton]", "{ball},{side},0.4895"),
    ],
)
def test_good_files_are_read(tmp_path, head: str, row: str) -> None:
    found = read_loads(written(tmp_path, head, row), 2)
    np.testing.assert_allclose(found.load, np.full((2, 4), 489.5), rtol=1e-12)


@pytest.mark.parametrize(
    ("head", "row", "words"),
    [
        ("ball,flank,newton", "{ball},{side}", "nothing"),
        ("newton,ball,flank", "489,{ball}", "flank"),
        ("ball,flank,newton", '{ball},{side},"489,5"', "decimal comma"),
        ("ball,flank,newton", '{ball},{side},"489', "quotation mark"),
        ("ball;flank;newton", "{ball};{side};489;517", "4 cells"),
    ],
)
def test_other_rows_that_do_not_fit(tmp_path, head: str, row: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_loads(written(tmp_path, head, row), 2)


def test_a_row_without_the_word_of_its_case_is_not_left_out(tmp_path) -> None:
    file = written(tmp_path, "ball,flank,newton,case", "{ball},{side},489.5,up")
    file.write_text(file.read_text(encoding="utf-8") + "2,NR,100\n", encoding="utf-8")
    with pytest.raises(InputError, match="case"):
        read_loads(file, 2, row_filter={"case": ("up",)})


def test_a_quantity_that_two_columns_give_is_refused(tmp_path) -> None:
    (tmp_path / "a.csv").write_text("quantity,value,unit,value\nrigidity,540,N/um,450\n", encoding="utf-8")
    with pytest.raises(InputError, match="one column value"):
        read_user_values(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "row", ["rigidity,540,5,N/um", 'rigidity,"540,5",N/um,', 'life,"540,5",revolutions,', 'rigidity,540,N/um,"5,5 kN"']
)
def test_a_decimal_comma_in_a_value_is_named(tmp_path, row: str) -> None:
    (tmp_path / "a.csv").write_text(f"quantity,value,unit,where\n{row}\n", encoding="utf-8")
    with pytest.raises(InputError, match="decimal comma"):
        read_user_values(tmp_path / "a.csv")


ROW = "{ball},{side},489.5"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encodings_that_their_mark_tells_are_read(tmp_path, encoding: str) -> None:
    file = written(tmp_path, "ball,flank,newton,approach_µm", ROW + ",5")
    file.write_text(file.read_text(encoding="utf-8"), encoding=encoding)
    found = read_loads(file, 2)
    assert (found.load[1, 3], found.further_quantities["approach"][1, 3]) == pytest.approx((489.5, 5e-6))


@pytest.mark.parametrize(
    ("encoding", "words"), [("utf-16-le", "UTF-16"), ("utf-16-be", "UTF-16"), ("latin-1", "Latin-1"), ("cp1252", "line 1")]
)
def test_other_encodings_are_named(tmp_path, encoding: str, words: str) -> None:
    file = written(tmp_path, "ball,flank,newton,approach_µm", ROW + ",5")
    file.write_bytes(file.read_text(encoding="utf-8").encode(encoding))
    with pytest.raises(InputError, match=words):
        read_loads(file, 2)
    scene = tmp_path / "a.toml"
    scene.write_bytes(catalogue.shipped_scene_text("two-balls").replace("Two", "µ").encode(encoding))
    with pytest.raises(InputError, match=words):
        catalogue.scene_of_any_kind(str(scene))


@pytest.mark.parametrize(("old", "new"), [('"6 um"', '"6,5 um"'), ("poissons_ratio = 0.28", "poissons_ratio = 0,28")])
def test_a_decimal_comma_in_a_scene_is_named(tmp_path, old: str, new: str) -> None:
    (tmp_path / "a.toml").write_text(catalogue.shipped_scene_text("two-balls").replace(old, new), encoding="utf-16")
    with pytest.raises(InputError, match="decimal comma"):
        catalogue.scene_of_any_kind(str(tmp_path / "a.toml"))


@pytest.mark.parametrize("options", [["--max-error", "7,5"], ["--limit", "rigidity=5,5"]])
def test_a_decimal_comma_on_the_command_line_is_named(command, options: list[str]) -> None:
    found = command("check", "two-balls", "--no-compute", *options)
    assert (found.code, "decimal comma" in found.err) == (2, True)
