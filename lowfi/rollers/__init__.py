"""Tapered rollers: line contact, a bearing's row, and its slices."""
