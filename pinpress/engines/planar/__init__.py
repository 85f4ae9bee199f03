"""The batched engine for planar linkages."""
