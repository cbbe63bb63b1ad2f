"""Names of the kinds of scenes that the core has; wings register others (`registration.kinds`)."""

#: Whole screws and bearings, which every command solves.
WHOLE = ("ball screw", "bearing")
#: Several rolling sets on one shaft.
AXIS = "axis"
