"""Mesh sizes derived from the expected contacts, and the meshes of screw, nut, balls and patches."""
