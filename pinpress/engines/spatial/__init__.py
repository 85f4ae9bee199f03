"""The engine of linkages in space: all configurations at once, with NumPy; it takes any linkage."""
