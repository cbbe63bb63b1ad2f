"""Screws with random errors as chains of balls, after Liu et al. (2025): ``lowfi.random_errors``."""
