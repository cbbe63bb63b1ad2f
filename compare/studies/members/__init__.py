"""Ensembles: many specimens (members) of a scene with random errors."""
