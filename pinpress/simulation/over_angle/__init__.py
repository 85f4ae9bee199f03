"""A crank that turns, solved over its angle."""
