"""Scenes, printed numbers, errors, gates and the command line: where models meet references."""

__version__ = "0.14.2"
