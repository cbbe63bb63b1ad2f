"""Sparse stiffnesses: in which order they are eliminated, factors, and what a body answers to loads."""
