"""Unilateral contact of balls between elastic bodies, and Hertz's contact in closed form, against which it is verified."""
