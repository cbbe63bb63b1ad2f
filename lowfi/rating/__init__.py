"""What contact loads mean for a designer: size and pressure of contacts, static safety, life, rigidity of the nut."""
