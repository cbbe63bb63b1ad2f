"""What the physics shares: parts and their exact geometry, units, sections (numpy only); and, for the 3D reference, meshes of
screw, nut, ball and patches by gmsh (`grooved_body`, `ball_body`, `shell`), their quality, and exchange with other programs."""
