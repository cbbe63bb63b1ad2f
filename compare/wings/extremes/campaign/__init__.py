"""A campaign of random extreme scenes, mutated files and kills, each judged by a check of its own."""
