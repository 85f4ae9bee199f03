"""The command `pinpress`."""
