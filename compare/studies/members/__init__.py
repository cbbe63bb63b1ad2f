"""Ensembles: many specimens of a scene with randomly drawn geometric errors."""
