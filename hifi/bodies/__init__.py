"""Finite-element bodies: coarse ones with refinement boxes, fine patches that fill these, short pieces at one contact."""
