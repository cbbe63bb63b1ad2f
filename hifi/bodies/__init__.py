"""Bodies from finite elements: coarse ones with sockets, fine patches, and pieces of a body around one contact."""
