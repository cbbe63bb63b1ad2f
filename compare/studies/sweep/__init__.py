"""A scene at many values of its keys."""
