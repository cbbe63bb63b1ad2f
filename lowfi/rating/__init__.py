"""Ratings from contact loads: size and pressure of contacts, static safety, life, rigidity of the nut."""
