"""Publications whose results are reproduced, one folder each; `rollbench.compare.case` describes their contents."""
