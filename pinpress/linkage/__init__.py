"""From a URDF to a checked `Linkage`, and back."""
