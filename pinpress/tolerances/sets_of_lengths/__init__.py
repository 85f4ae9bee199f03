"""A press with many sets of lengths at once: each set is closed and followed to a dead centre or height."""
