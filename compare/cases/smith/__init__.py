"""Smith (1994), thesis on the support bearings of ball screws: printed numbers, reproduced."""
