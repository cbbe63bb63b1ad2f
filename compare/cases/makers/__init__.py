"""Makers' printed tables and a few measurements of bearings and ball nuts, compared with computed values."""
