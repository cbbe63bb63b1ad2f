"""What is computed for the thesis's printed numbers, section by section."""
