"""Simulate magnitude-estimation studies as arrays: people, orders and vectorised tests."""
