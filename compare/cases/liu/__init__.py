"""Liu et al. (2025), Lubricants 13, 57."""
