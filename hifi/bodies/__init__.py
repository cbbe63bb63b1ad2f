"""Finite-element bodies: coarse ones with sockets, fine patches that fill these, and short pieces around one contact."""
