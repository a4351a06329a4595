"""Enumerate every raw data set consistent with a published table of n, mean and SD."""
