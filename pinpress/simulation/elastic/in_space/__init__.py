"""Linkages in space on springs."""
