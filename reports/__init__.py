"""Drawing and writing of reports from plain records; no model is imported."""
