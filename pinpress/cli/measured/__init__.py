"""Commands that read records of a press: what it is, its process force, its vibration."""
