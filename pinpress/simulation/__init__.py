"""Motion found from drives and loads."""
