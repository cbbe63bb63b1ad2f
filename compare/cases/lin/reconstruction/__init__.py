"""Reconstruction of the errors printed in 2.4.1: combinations of interpretations of what the text leaves open."""
