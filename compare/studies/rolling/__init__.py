"""Comparison of low-order models of rolling balls with the 3D model of rolling."""
