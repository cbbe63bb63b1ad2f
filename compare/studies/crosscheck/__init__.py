"""Comparison of the 3D reference with CalculiX."""
