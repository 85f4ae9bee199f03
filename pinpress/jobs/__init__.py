"""A job file: the press and all that acts on it in one YAML, see `job`."""
