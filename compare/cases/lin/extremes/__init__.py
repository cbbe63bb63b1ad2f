"""Perturbed cases of the thesis's chapter 3 with friction: which formulation answers how often."""
