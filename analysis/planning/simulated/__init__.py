"""Simulate and test many magnitude-estimation studies at once, with array operations."""
