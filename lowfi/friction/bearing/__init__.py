"""Friction of balls in rotary bearings: one ball between rings, and bearings in pairs."""
