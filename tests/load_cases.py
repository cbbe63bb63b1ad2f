"""A scene file with three load cases of two balls between rings: small in the low order and in 3D."""

import json
from pathlib import Path

from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.catalogue import shipped_scene_text

#: Cases of the shipped scene two-balls: as it is, pushed harder, and a static check of looser balls.
CASES = """
[[cases]]
name = "balls"
share = 0.75

[[cases]]
name = "push"
share = 0.25
[[cases.supports]]
at = "7 mm"
displace = { uz = "8 um" }

[[cases]]
name = "loose"
share = 0
oversize = "2 um"
"""
TEXT = shipped_scene_text("two-balls") + "\n[friction]\ncoefficient = 0.1\n" + CASES


def case(name: str, force: str = "", **keys: object) -> str:
    """A load case as text, with a force along the axis at the shaft's left end."""
    said = "".join(f"{key} = {json.dumps(value)}\n" for key, value in ({"name": name} | keys).items())
    loads = f'[[cases.loads]]\nat = "0 mm"\nforce = ["0 N", "0 N", "{force}"]\n' if force else ""
    return f"\n[[cases]]\n{said}{loads}"


def written(folder: Path, text: str = TEXT) -> str:
    """The text as ``two.toml`` in a folder: its first case is named two-balls, as the shipped scene."""
    path = folder / "two.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


SHIPPED = catalogue.scene("two-balls")
