"""Several rolling sets on one shaft: one energy, one equilibrium."""
