"""Compute statistics, or return the reason why a result is missing."""
