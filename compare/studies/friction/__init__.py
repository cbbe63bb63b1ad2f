"""Friction of whole screws and bearings, and of single parts (balls, pairs, chains) for which only friction is computed."""
