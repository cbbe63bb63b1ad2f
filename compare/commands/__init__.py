"""The commands of the command line, one module each: they ask, compute through the packages below, and print."""
