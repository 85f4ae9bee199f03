"""Linkages in other formats than URDF with ``<loop_joint>``: a reader each, which gives what the file says as such a URDF."""
