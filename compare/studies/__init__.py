"""Computations of more than one solution: sweeps, samples of errors, mesh studies, friction, rolling, other programs."""
