"""Friction of balls in linear bearings: one ball, pairs and chains in contact."""
