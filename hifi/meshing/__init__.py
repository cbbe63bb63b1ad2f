"""Mesh sizes from the expected contacts, and the meshes of one geometry."""
