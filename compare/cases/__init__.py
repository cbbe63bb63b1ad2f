"""Publications whose results are reproduced, one folder each; `rollbench.compare.case` describes their contents.

To add one: `tests/acme.py` is a whole case in one page.
"""
