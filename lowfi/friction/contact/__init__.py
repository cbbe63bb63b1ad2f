"""Friction of elliptical rolling contacts and the motion of least dissipation of a ball."""
