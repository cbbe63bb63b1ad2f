"""Sections of the report on Lin's thesis."""
