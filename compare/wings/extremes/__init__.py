"""Numerical stability: models and formulations on stiff and extreme cases, counted."""
