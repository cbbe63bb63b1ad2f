"""Sections of the report on the thesis."""
