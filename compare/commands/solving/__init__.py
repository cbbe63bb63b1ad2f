"""One scene by a low-order model: answers, members, curves, files."""
