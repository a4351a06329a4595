"""Design plates that meet given requirements."""
