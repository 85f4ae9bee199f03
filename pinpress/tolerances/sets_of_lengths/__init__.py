"""A press with many sets of lengths at once: each closed with its own, and followed to where its slide ends."""
