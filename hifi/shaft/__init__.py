"""The shaft beyond the 3D stretch: beams, the section of the grooved shaft, and where the 3D stretch is cut."""
