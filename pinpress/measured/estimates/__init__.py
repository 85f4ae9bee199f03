"""From records to estimates: weak equations, what is known before, least squares with their deviations, cones, base parameters."""
