"""Run times of models and of the 3D reference, measured and kept."""
