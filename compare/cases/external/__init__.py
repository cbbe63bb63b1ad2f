"""Other programs, makers' catalogues and textbooks."""
