"""Scenes of rolling balls by the low-order models and in 3D: runs, their store, rows."""
