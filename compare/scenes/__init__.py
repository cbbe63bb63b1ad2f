"""Scene files: schema, units, reading, refusing, and the scenes that the package ships."""
