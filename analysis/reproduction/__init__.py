"""Reproduce the tables and figures of the paper, and compare them with the published values."""
