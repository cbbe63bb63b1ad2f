"""Rolling contact in 3D against the low-order models."""
