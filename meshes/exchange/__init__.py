"""Whole bodies, meshes and input decks as files for other programs."""
