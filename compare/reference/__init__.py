"""The 3D reference: mesh levels, computing and storing runs, and contact loads of a scene with their grid uncertainty."""
