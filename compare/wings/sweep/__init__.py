"""Designs of experiments over the keys of a scene: one stored record a sample, and what they say together."""
