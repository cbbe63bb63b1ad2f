"""Sweep: a scene solved for sampled values of its keys."""
