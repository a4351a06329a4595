"""Simulated participants: the population, how each person answers, and their runs."""
