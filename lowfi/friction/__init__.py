"""Friction of elliptical rolling contacts, and the quasi-static motion of balls under this friction."""
