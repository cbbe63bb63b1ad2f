"""Kalker's table of creep coefficients, and the proof of the 3D model of rolling."""
