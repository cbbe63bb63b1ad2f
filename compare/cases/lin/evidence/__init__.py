"""Computed values for the numbers printed in Lin's thesis, section by section."""
