"""From records to estimates: weak equations, the prior, least squares with standard deviations, cones, base parameters."""
