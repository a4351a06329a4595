"""Normalise raw estimates, take logarithms and check data quality."""
