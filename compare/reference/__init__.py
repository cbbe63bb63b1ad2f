"""The 3D reference: mesh levels, runs, their store, and what a scene's reference is worth."""
