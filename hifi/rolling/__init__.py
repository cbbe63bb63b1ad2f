"""Rolling with friction in 3D: elastic micro-slip in the contacts of balls, and friction between touching balls."""
