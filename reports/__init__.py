"""Drawing and writing of reports from plain records; imports no model."""
