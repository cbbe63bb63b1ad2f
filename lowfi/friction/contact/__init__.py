"""Friction of elliptical rolling contacts, contact loads of balls between rigid bodies, and a ball's least dissipation."""
