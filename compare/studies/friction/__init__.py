"""Friction of whole screws and bearings, and of the kinds of scenes that only friction solves."""
