"""The 3D reference on several mesh levels."""
