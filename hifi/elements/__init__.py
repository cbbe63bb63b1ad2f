"""Finite elements: weak forms, their fast assembly, pressures as hats, rigid motions."""
