"""Compute statistics of prepared data; each returns its result or why it is missing."""
