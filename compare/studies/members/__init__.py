"""Ensembles: a scene solved for many random draws of its geometric errors (each draw is called a specimen)."""
