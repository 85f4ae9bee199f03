"""Frames of robots: the drivers that bring them to places, and what they reach."""
