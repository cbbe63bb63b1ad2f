"""Kinds of scenes of chapters 3 and 4 of Lin's thesis: their files, their friction, and their balls as rolling balls."""
