"""Lin (2019), doctoral thesis."""
