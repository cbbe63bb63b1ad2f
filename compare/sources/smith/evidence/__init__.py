"""Smith (1994): our value beside every printed number and claim, with evidence. Printed data: ``printed/smith-*``."""
