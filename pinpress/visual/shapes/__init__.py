"""The drawn shapes of a press: its visuals, or stand-ins for them."""
