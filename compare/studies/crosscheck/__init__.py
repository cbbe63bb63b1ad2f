"""Comparison of the 3D reference with the finite-element program CalculiX."""
