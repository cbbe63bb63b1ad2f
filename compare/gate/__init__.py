"""Acceptance checks (the gate): verdicts on models and users' loads, against the 3D reference and published numbers."""
