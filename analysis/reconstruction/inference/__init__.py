"""Compute bounds and distributions of test results over all data sets consistent with a table."""
