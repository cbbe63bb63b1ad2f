"""Keys and records of the kinds of scenes for which only friction is computed."""
