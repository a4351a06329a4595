"""Session as a factor."""
