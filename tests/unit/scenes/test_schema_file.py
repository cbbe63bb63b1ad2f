"""Editors: the shipped schema file is the one that is printed, and a new scene names it."""

import json
import re
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest

from rollbench.comparison.registration import ROOT
from rollbench.comparison.scenes.kinds import json_schema


def test_shipped_schema_is_the_printed_one() -> None:
    """To renew it: rollbench schema > compare/scene.schema.json."""
    assert json.loads((ROOT / "scene.schema.json").read_text(encoding="utf-8")) == json.loads(json.dumps(json_schema()))


@pytest.mark.parametrize("words", [("--like", "16x5"), ("--kind", "axis")])
def test_a_new_scene_names_the_schema(tmp_path: Path, words: tuple[str, ...], command) -> None:
    command("new", tmp_path / "my.toml", *words)
    first = (tmp_path / "my.toml").read_text(encoding="utf-8").splitlines()[0]
    found = re.fullmatch(r"#:schema (file://.*)", first)
    assert json.loads(Path(unquote(urlparse(found[1]).path)).read_text(encoding="utf-8"))["$id"] == "urn:rollbench:scene"
