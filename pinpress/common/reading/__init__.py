"""What is read from files of others: entries that know where they stand, and matrices."""
