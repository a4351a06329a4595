"""Scales from paired comparison and triads."""
