"""Draws and writes reports from plain records; imports no model."""
