"""The `Motion` of a linkage, and what is read off it."""
