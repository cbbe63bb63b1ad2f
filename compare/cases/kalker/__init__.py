"""Kalker (1990): table of creep coefficients, and verification of the 3D model of rolling contact."""
