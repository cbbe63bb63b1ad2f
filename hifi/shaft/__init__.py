"""Shaft of the 3D reference: beams, the section of the grooved shaft, and the ends of the stretch that is meshed in 3D."""
