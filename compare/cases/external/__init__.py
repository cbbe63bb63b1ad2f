"""Published values of other programs, makers' catalogues and textbooks, compared with computed ones."""
