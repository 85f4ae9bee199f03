"""The text of a URDF: read, checked, edited."""
