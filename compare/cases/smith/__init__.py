"""Smith (1994), thesis on ball screws and their bearings."""
