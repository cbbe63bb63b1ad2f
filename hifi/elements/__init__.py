"""Finite elements: weak forms, their fast assembly, pressure basis functions, rigid motions."""
