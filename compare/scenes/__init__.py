"""Scene files: schema, units, reading, checks, and the scenes that are included in rollbench."""
