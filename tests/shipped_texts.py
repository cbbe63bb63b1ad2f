"""Shared by the tests of friction scenes: shipped scenes as text, and with lines changed."""

from compare.scenes import catalogue


def text(name):
    return catalogue.scene_text(name)


def changed(name, *changes):
    out = text(name)
    for old, new in changes:
        assert old in out, f"{name} has no {old}"
        out = out.replace(old, new, 1)
    return out
