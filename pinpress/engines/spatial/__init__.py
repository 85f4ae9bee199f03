"""The general engine: Pinocchio, one configuration at a time."""
