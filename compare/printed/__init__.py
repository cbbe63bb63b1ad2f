"""Numbers and claims printed in the sources, as data."""
