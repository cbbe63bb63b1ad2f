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


def written(folder: Path, head: str, row: str) -> Path:
    """A table with the same row for every contact of the two balls."""
    file = folder / "a.csv"
    rows = [row.format(ball=ball, side=side) for ball in (1, 2) for side in ("SL", "SR", "NL", "NR")]
    file.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return file


READERS = {
    "loads": ("ball,flank,newton", "{ball},{side},489,517", lambda file: read_loads(file, TWO)),
    "filled up": ("ball,flank,newton,,", "{ball},{side},489,517,", lambda file: read_loads(file, TWO)),
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


GOOD = "ball,flank,newton\n1,SL,100\n1,NR,90.5\n2,sl,0\n2,NR,80\n"
SAVED = [
    GOOD,
    GOOD.replace(",", "\t"),
    GOOD.replace("\n", "\r\n") + "\n\n",
    GOOD.replace(",", ";").replace(".", ","),
    "sep=;\n" + GOOD.replace(",", ";").replace(".", ","),
    "sep=|\n" + GOOD.replace(",", "|").replace(".", ","),
    "SEP=,\n" + GOOD,
    GOOD.replace("ball,flank,newton", "Ball,FLANK,Load [Newton]"),
    GOOD.replace("ball,flank,newton", "ball,flank,newton,,"),
    GOOD.replace("90.5", "90.5,,"),
    GOOD.replace("ball,", ",ball,").replace("1,", "7,1,").replace("2,", "7,2,"),
    "flank,newton,ball,note\nSL,100,1,x\nNR,90.5,1,\nSL,0,2\nNR,80,2,y\n",
]


@pytest.mark.parametrize("text", SAVED)
def test_good_files_are_read(tmp_path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8", newline="")
    found = read_loads(tmp_path / "a.csv", TWO)
    assert found.flanks_with_rows == ("SL", "NR")
    np.testing.assert_array_equal(found.load, [[100.0, 0.0, 0.0, 90.5], [0.0, 0.0, 0.0, 80.0]])


FAULTY = [
    ("ball,", "index,", "line 1", "a column ball"),
    ("1,SL,100", "3,SL,100", "line 2: ball", "1 to 2"),
    ("1,SL,100", "1,left,100", "line 2: flank", "SL, SR, NL, NR"),
    ("1,SL,100", "1,SL,-100", "line 2: newton", "at least 0"),
    ("1,SL,100", "1,SL,nan", "line 2: newton", "at least 0"),
    ("1,SL,100", "1,SL,100 N", "line 2: newton", "without unit"),
    ("1,SL,100", "1,SL", "line 2: newton", "nothing"),
    ("1,SL,100", '1,SL,"489,5"', "line 2: newton", "decimal comma"),
    ("1,SL,100", "1,SL,1_000", "line 2: newton", "underscore"),
    ("1,SL,100", "1,SL,0.1D+03", "line 2: newton", "Fortran"),
    ("1,SL,100", "1,SL,١٠٠", "line 2: newton", "at least 0"),
    ("1,SL,100", '1,SL,"100', "line 5", "quotation mark"),
    ("2,sl,0\n", "", "rows", "no load of ball 2 SL"),
    ("2,NR,80", "1,NR,80", "line 5", "ball 1 NR"),
    (GOOD, "", "line 1", "ball,flank,newton"),
    (GOOD, "ball,flank,newton\n", "file", "no loads"),
    (GOOD, "newton,ball,flank\n489,1\n", "line 2: flank", "no cell after 489,1"),
    (GOOD, "ball;flank;newton\n1;SL;489;517\n", "line 2", "4 cells"),
    (GOOD, "ball,flank,newton,load_kN\n1,SL,100,0.1\n", "line 1", "one column for each quantity"),
    (GOOD, "ball,flank,newton,angle_deg\n1,SL,100,\n2,SL,100,\n", "rows", "no angle of ball 1 SL"),
    (GOOD, "ball,flank,newton,pressure_MPa\n1,SL,100,inf\n", "line 2: pressure_MPa", "at least 0"),
]


@pytest.mark.parametrize(("old", "new", "key", "words"), FAULTY)
def test_faulty_loads_are_refused_by_line(tmp_path, old: str, new: str, key: str, words: str) -> None:
    (tmp_path / "a.csv").write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_loads(tmp_path / "a.csv", TWO)
    assert caught.value.key == key
    assert words in str(caught.value)


def test_a_row_without_the_word_of_its_case_is_not_left_out(tmp_path) -> None:
    file = written(tmp_path, "ball,flank,newton,case", "{ball},{side},489.5,up")
    with file.open("a", encoding="utf-8") as more:
        more.write("2,NR,100\n")
    with pytest.raises(InputError, match="case"):
        read_loads(file, TWO, row_filter={"case": ("up",)})


@pytest.mark.parametrize(
    "row", ["rigidity,540,5,N/um", 'rigidity,"540,5",N/um,', 'life,"540,5",revolutions,', 'rigidity,540,N/um,"5,5 kN"']
)
def test_a_decimal_comma_in_a_value_is_named(tmp_path, row: str) -> None:
    with pytest.raises(InputError, match="decimal comma"):
        read_user_values(written(tmp_path, "quantity,value,unit,where", row))


@pytest.mark.parametrize(("number", "words"), [("1_000", "underscore"), ("1.5D+03", "Fortran")])
@pytest.mark.parametrize("row", ["rigidity,{},N/um,", "life,{},revolutions,", "rigidity,540,N/um,{} N"])
def test_another_spelling_of_a_value_is_named(tmp_path, row: str, number: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_user_values(written(tmp_path, "quantity,value,unit,where", row.format(number)))


def test_a_quantity_that_two_columns_give_is_refused(tmp_path) -> None:
    with pytest.raises(InputError, match="one column value"):
        read_user_values(written(tmp_path, "quantity,value,unit,value", "rigidity,540,N/um,450"))


MICRO = "ball,flank,newton,approach_µm", "{ball},{side},489.5,5"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encodings_that_their_mark_tells_are_read(tmp_path, encoding: str) -> None:
    file = written(tmp_path, *MICRO)
    file.write_text(file.read_text(encoding="utf-8"), encoding=encoding)
    found = read_loads(file, TWO)
    assert (found.load[1, 3], found.further_quantities["approach"][1, 3]) == pytest.approx((489.5, 5e-6))


@pytest.mark.parametrize(
    ("encoding", "words"), [("utf-16-le", "UTF-16"), ("utf-16-be", "UTF-16"), ("latin-1", "Latin-1"), ("cp1252", "line 1")]
)
def test_other_encodings_are_named(tmp_path, encoding: str, words: str) -> None:
    file = written(tmp_path, *MICRO)
    file.write_bytes(file.read_text(encoding="utf-8").encode(encoding))
    with pytest.raises(InputError, match=words):
        read_loads(file, TWO)
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
    assert "decimal comma" in command.refused("check", "two-balls", "--no-compute", *options)
