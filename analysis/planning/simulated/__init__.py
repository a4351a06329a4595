"""Simulate studies of estimates as arrays: people, orders, and vectorised tests."""
