"""Lin's formulations of friction, as printed."""
