"""Formulations of the source, its misprints mended, kept for comparison: root finding, as printed."""
