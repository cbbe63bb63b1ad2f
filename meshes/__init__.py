"""Parts of ball screws and bearings for all models: records, exact geometry, units; meshes for the 3D reference.

Screw, nut, balls and contact patches are meshed by gmsh (`grooved_body`, `ball_body`, `shell`, `tet_patch`). The package
`exchange` writes files for other programs. The modules `parts`, `helix`, `surface` and `section` need only numpy.
"""
