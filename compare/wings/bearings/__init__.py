"""Closed formulas of bearings and axes, as Smith (1994) and makers print them: ``lowfi.bearings``."""
