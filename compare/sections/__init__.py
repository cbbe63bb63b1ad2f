"""Sections of the validation report, each made by one module that solves scenes and returns tables, figures and texts."""
