"""Publications whose results are reproduced, one folder each; `rollbench.compare.case` describes their contents.

An example of how to add one is `tests/acme.py`, which contains all parts of a case.
"""
