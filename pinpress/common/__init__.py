"""Ground: arrays, units, errors, argument checks, whole-file writing, tables, small numerics. It imports nothing of the other rooms."""
