"""Write whole bodies, meshes and input decks to files for other programs."""
