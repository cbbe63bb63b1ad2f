"""What the physics shares: parts and their exact geometry, units, sections; meshes of bodies for the 3D reference.

Screw, nut, ball and patches are meshed by gmsh (`grooved_body`, `ball_body`, `shell`); `exchange` writes files of others.
Parts, helix, surface and sections need numpy alone.
"""
