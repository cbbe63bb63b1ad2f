"""Stiff and extreme scenes, and records of random campaigns."""
