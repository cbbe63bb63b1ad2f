"""The 3D reference: mesh levels, runs, their store, and a scene's reference with its grid uncertainty."""
