"""Read the command line: options of several commands, parts described by their keys, numbers with units."""
