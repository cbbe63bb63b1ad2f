"""Three examples of the library: a catalogue page, a check of spreadsheet loads, and a notebook (``notebook.ipynb``)."""
