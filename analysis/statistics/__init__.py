"""Compute statistics, or return the reason why there is no result."""
