"""Names of the kinds of scenes."""

#: Whole screws and bearings, which every command solves.
WHOLE = ("ball screw", "bearing")
#: Several rolling sets on one shaft.
AXIS = "axis"
#: What only friction solves.
KINDS = ("bearing ball", "bearing pair", "linear pair", "linear chain", "screw pair", "screw run")
