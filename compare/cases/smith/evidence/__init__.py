"""Smith (1994): the computed value beside every printed number and claim, with evidence.

Printed data: ``printed/smith-*``.
"""
