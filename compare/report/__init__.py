"""The report and the page of a scene: what stands on them, and how they are written."""
