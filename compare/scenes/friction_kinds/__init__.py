"""Keys and records of the kinds of scenes that only friction is computed for."""
