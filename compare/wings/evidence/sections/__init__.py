"""Sections of the report: every printed entry with its verdict, and what does not reproduce."""
