"""Acceptance checks (the gate): verdicts on models and on users' loads, against the 3D reference and printed numbers."""
