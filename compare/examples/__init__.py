"""Three examples of the library: a catalogue page, a gate on a spreadsheet, and a notebook (``notebook.ipynb``)."""
