"""Simulated participants: the population, how one person answers, and their runs."""
