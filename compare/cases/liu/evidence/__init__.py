"""Liu et al. (2025): the computed value beside every printed number and claim, with evidence.

Printed data: ``printed/liu-*``.
"""
