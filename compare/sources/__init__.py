"""One folder a source: printed data, scenes, evidence and section of the report, registered in ``source.py``."""
