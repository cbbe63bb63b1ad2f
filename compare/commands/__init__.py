"""Commands of the command line, one module for each: options, calls of the computing packages, and printed output."""
