"""What the bodies are: parts, exact geometry of helix, grooves and balls with their errors (numpy only)."""
