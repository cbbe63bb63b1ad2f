"""Scene files: schema, units, reading, checks, and the shipped scenes."""
