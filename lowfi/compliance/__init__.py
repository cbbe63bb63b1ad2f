"""Elastic compliance of screw, nut and balls between contact points: motion of every contact by a force on any contact."""
