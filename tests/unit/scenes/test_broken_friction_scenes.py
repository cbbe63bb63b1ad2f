"""Deliberately broken friction scenes: each gives one line that says where, what and what to do; and their schema."""

import json

import pytest

from rollbench.comparison.errors import InputError, SceneError
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.keys import tidy_schema
from rollbench.comparison.wings.friction.kinds.table import KINDS


def test_files_and_names_that_do_not_exist(tmp_path):
    with pytest.raises(InputError, match="did you mean lin-rotary-1"):
        catalogue.any_scene("lin-rotary1")
    with pytest.raises(SceneError, match="no such file"):
        catalogue.any_scene(str(tmp_path / "none.toml"))
    empty = tmp_path / "empty.toml"
    empty.write_text("", encoding="utf-8")
    with pytest.raises(SceneError, match="title: got nothing"):
        catalogue.any_scene(str(empty))


@pytest.mark.parametrize("kind", list(KINDS))
def test_schema_describes_every_key(kind):
    schema = tidy_schema(KINDS[kind].keys)
    nodes = [schema, *schema["$defs"].values()]
    for node in nodes:
        for name, entry in node.get("properties", {}).items():
            assert entry.get("description"), name
    json.dumps(schema, allow_nan=False)
