"""Machine elements: what acts in their contacts, and the laws of cams."""
