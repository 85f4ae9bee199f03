"""What is drawn of a press: its visuals, or stand-ins for them."""
