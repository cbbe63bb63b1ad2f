"""The report and the page of a scene: their contents, and writing them."""
