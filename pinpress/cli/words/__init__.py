"""What the words of the command line mean: options that several commands have, parts described by their keys, numbers with units."""
