"""Shared by all models: parts and their exact geometry, units, sections; meshes of bodies for the 3D reference.

Screw, nut, ball and patches are meshed by gmsh (`grooved_body`, `ball_body`, `shell`); `exchange` writes files for other
programs. Parts, helix, surface and sections need only numpy.
"""
