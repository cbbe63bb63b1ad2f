"""Makers' tables and the few measurements that can be read, and what this project computes for them."""
