"""Friction of balls in a ball screw: one, two that touch, and a whole screw over time."""
