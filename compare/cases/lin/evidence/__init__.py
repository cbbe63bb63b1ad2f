"""Computed values for the thesis's printed numbers, section by section."""
