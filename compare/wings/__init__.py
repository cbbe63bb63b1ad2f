"""Wings: what a user may leave out. Each folder holds one, with its ``registration.py``."""
