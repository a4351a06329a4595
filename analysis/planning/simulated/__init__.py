"""Simulate and test many magnitude-estimation studies at once, as arrays."""
