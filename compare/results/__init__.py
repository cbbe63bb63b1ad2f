"""Results of the library: immutable records in SI units, made from the solvers' records, and their JSON."""
