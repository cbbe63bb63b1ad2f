"""The 3D reference on several mesh levels: observed orders, uncertainty of every quantity, modelling spread."""
