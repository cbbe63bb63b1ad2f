"""Physics as publications did it, to reproduce their numbers: imported by the cases of ``compare`` only."""
