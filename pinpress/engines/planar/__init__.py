"""The planar engine computes all crank angles of a planar linkage at once."""
