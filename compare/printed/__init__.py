"""Numbers and claims printed in the sources, as data, and what this project finds for them."""
