"""The 3D reference checked by another program: decks, its answers, and the comparison."""
