"""The 3D reference against CalculiX."""
