"""Ordinary catalogue screws, drawn by one seed: does the 3D reference answer each, and how far off are models."""
