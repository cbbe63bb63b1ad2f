"""Meshes and result fields of the 3D reference as files for other programs."""
