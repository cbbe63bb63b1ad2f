"""A folder a case, as `rollbench.compare.case` describes it."""
