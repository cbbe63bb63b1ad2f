"""Names of files and scenes like a misspelt one."""

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
