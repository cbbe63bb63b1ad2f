"""Conversion of results to text and tables for the terminal."""
