"""Sessions as a factor."""
