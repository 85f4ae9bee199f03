"""Elastic motion: a press whose bearings, guides, rods, shaft and frame yield while it runs."""
