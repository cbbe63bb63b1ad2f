"""One module a law: what it computes for every table that the law rules."""
