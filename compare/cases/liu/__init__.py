"""Liu et al. (2025), Lubricants 13, 57: contact loads of a ball screw with random geometric errors, reproduced."""
