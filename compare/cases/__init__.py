"""Cases of the comparison, one folder each; `rollbench.compare.case` describes their contents."""
