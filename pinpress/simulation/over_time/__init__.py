"""Runs over time: equations of motion, modes of couplings and loads, events that end them, and integration from one to the next."""
