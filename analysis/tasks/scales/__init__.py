"""Scales from paired comparisons and triads."""
