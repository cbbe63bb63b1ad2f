"""Many members of a scene with random errors."""
