"""Sections of the report on run times: error against run time, and what each release reached."""
