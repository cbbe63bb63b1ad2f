"""Unilateral contact of balls between elastic bodies, and Hertz's contact, against which it is verified."""
