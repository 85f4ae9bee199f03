"""Loads on a motion, and the `Reactions` to it."""
