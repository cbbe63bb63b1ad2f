"""Drawn catalogue screws on the 3D reference."""
