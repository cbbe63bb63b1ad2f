"""Support bearings of a screw under thrust and combined load, and the closed formulas of a ball-screw axis."""
