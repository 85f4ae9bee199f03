"""Which joints drive a linkage, and what becomes of the freedoms that no motor moves."""
