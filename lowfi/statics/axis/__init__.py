"""Static equilibrium of one shaft with several bearings and ball nuts."""
