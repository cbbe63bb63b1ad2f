"""Computations beyond one solve: sweeps, samples, mesh studies, friction, rolling, checks by other programs."""
