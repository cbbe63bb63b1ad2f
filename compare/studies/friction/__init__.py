"""Friction of ball screws and bearings: torques, losses, motion of the balls, and how friction feeds back on the loads."""
