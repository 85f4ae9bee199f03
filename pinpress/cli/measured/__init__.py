"""Commands that read records of a press: identification, process force and vibration."""
