"""Smith (1994): computed values of every printed number and claim.

Printed data: ``printed/smith-*``.
"""
