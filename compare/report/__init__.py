"""Makes and writes the validation report, and the pages on single scenes."""
