"""Simulate a study many times to show how much its results can vary by chance."""
