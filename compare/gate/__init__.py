"""The gate of continuous integration: what must hold, as rows with a verdict."""
