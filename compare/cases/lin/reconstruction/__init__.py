"""Reconstruction of the model errors printed in section 2.4.1 of Lin's thesis, by combining interpretations of its text."""
