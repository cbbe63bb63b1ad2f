"""Models by name, their results on scenes, and their comparison with the 3D reference."""
