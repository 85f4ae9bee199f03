"""What results show, and how texts and notebooks show it."""
