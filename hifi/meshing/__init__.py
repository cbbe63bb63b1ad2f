"""Sizes of meshes, from the contacts that are expected, and the meshes of one geometry."""
