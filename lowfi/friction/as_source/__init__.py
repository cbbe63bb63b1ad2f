"""The source's own formulations of friction, as printed."""
