"""Friction and ball motion of whole screws and bearings, and the scenes that only friction solves."""
