"""Models beside the 3D reference: compare, check, mesh-study, condense."""
