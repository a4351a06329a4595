"""Simulate a study many times, to show how much its table of results can vary."""
