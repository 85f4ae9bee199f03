"""Presses from pin tables: pins and links as engineers draw them, in a YAML file or a call."""
