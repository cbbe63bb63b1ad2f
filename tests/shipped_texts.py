"""Shared by the tests of scenes: shipped scenes and those of tests as text, with lines changed; the names of the axes."""

from pathlib import Path

from tests.load_cases import TEXT

from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.template import commented_template
from rollbench.meshes.axis import Assembly

SCENES = Path(__file__).parent / "scenes"


def axis_names():
    return tuple(name for name in catalogue.scene_names() if isinstance(catalogue.shipped_scene(name), Assembly))


def own_text(name):
    """Text of a scene that only tests have."""
    return (SCENES / f"{name}.toml").read_text(encoding="utf-8")


def text(name):
    """Text of a scene: of tests, commented, with load cases, or shipped."""
    if (SCENES / f"{name}.toml").exists():
        return own_text(name)
    others = {"support-bearings": lambda: commented_template(name), "load cases": lambda: TEXT}
    return others.get(name, lambda: catalogue.shipped_scene_text(name))()


def parse_file(path):
    """The ball screw or bearing of a scene file."""
    return scene_file.scene_from_text(scene_file.read_scene_text(path), str(path))


def changed(name, *changes):
    out = text(name)
    for old, new in changes:
        assert old in out, f"{name} has no {old}"
        out = out.replace(old, new, 1)
    return out
