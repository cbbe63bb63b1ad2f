"""Stored files of version 0.4.4 and before, named by the keys of today: ``python -m
rollbench.comparison.renaming``."""
