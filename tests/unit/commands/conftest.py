"""Shared by the tests of commands: scene files with texts changed."""

from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def scene_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes the text of a scene as ``my.toml``, each pair of an old and a new text changed at its first place."""

    def write(text: str, *changes: tuple[str, str]) -> Path:
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        (tmp_path / "my.toml").write_text(text, encoding="utf-8")
        return tmp_path / "my.toml"

    return write
