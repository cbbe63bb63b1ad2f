"""Computed values for the numbers and claims printed by Smith (1994).

Printed data: ``printed/smith-*``.
"""
