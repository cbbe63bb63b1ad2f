"""Words of engineers and catalogues for keys of a scene, as hints beside an unknown key."""

from __future__ import annotations

from rollbench.comparison import data

#: Unknown key, in lower case with underscores, and what it is called in a scene.
WORDS: dict[str, str] = data.table("words.toml")


def hint(name: str) -> str:
    """What an unknown key is called in a scene, or nothing."""
    return WORDS.get(name.strip().lower().replace("-", "_").replace(" ", "_"), "")
