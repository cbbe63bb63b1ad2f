"""Ratings from contact loads: contact size and pressure, static safety, fatigue life, rigidity of the nut, shaft limits."""
