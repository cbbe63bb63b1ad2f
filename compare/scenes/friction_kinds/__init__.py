"""Keys and records of the scenes that only friction solves."""
