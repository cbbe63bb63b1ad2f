"""Typed results of the library: frozen records in SI units, built from the solvers' records, with their JSON."""
