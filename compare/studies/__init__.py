"""What is computed beyond one solve: sweeps, members, mesh studies, friction, rolling, checks by other programs."""
