"""Liu et al. (2025): our value beside every printed number and claim, with evidence. Printed data: ``printed/liu-*``."""
