"""Matching of a reference by adjustment."""
