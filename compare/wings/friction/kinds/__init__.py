"""Kinds of scenes of the source's modules of friction: their keys, what they may not describe, and their records."""
