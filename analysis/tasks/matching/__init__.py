"""Matching of a reference."""
