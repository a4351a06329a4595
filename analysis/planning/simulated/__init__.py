"""Simulated studies of estimates, as arrays: people, orders, and their fast tests."""
