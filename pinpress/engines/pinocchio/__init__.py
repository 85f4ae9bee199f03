"""Pinocchio's engine computes any linkage, one configuration at a time."""
