"""Bounds and distributions of test results over the data sets behind a table."""
