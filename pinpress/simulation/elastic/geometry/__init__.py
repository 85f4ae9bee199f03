"""Bodies in a plane and in space, and the lines between them along which springs act."""
