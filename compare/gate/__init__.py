"""The gate: pass or fail verdicts on models and on users' loads, against the 3D reference and printed numbers."""
