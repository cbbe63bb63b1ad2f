"""Many members of a scene with random errors: bands and distributions."""
