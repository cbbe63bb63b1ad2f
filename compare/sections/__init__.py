"""Sections of the validation report, one module each: they run models and fill plain records."""
