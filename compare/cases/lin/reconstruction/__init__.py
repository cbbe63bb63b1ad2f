"""What the source may have done to print the errors of 2.4.1: readings of what the text leaves open, combined."""
